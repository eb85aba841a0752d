"""Checks that a take can be made, before any work is done."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from ...errors import SampError
from ...methods.scene_view import SceneView
from ..actions import keyframes
from ..character import armature

HEIGHTS = (0.5, 3.5)
"""Plausible metres from sole to head joint; larger characters were modelled in centimetres or feet."""

LARGEST = 12.0
"""Largest plausible extent of furniture in metres, checked where the scene's unit is not the metre."""

FARTHEST = 250.0
"""Longest walk of a take in metres; a larger navmesh is too coarse."""


def check(context: bpy.types.Context, owner: bpy.types.Object | None, views: Sequence[SceneView]) -> None:
    """Raise SampError where the character cannot get an Action, its size is implausible, or the goal is too far."""
    if owner is not None:
        keyframes.require_editable(owner)
        _check_size(context, owner)
    _check_units(context, views)
    _check_distance(context, views)


def check_writable(context: bpy.types.Context, owner: bpy.types.Object | None) -> None:
    """Raise SampError where the artist's changes since the start prevent a finished take from being written."""
    if owner is not None:
        keyframes.require_editable(owner)
    elif context.mode not in ("OBJECT", "POSE"):
        raise SampError("A new character cannot be created in this mode; go to Object Mode and start again.")


def _check_size(context: bpy.types.Context, owner: bpy.types.Object) -> None:
    rest = armature.calibrate(owner).rest_joints
    height = float(np.ptp(rest[:, 1]))
    if not HEIGHTS[0] <= height <= HEIGHTS[1]:
        raise SampError(
            f"'{owner.name}' is {height:.2g} units tall, and a unit is a metre here; "
            f"scale it and the room to metres{_unit_scale(context)}."
        )


def _check_units(context: bpy.types.Context, views: Sequence[SceneView]) -> None:
    """Raise SampError for furniture as large as a house in a scene whose unit is not the metre."""
    for view in views:
        target = view.target
        if target is None or not _unit_scale(context):
            continue
        size = float(np.ptp(target, axis=(0, 1)).max())
        if size > LARGEST:
            raise SampError(
                f"The furniture is {size:.0f} units large, and a unit is a metre here; "
                f"scale it and the room to metres{_unit_scale(context)}."
            )


def _check_distance(context: bpy.types.Context, views: Sequence[SceneView]) -> None:
    """Raise SampError where a step's end is too far from its start."""
    start = views[0].start
    position = None if start is None else start[0]
    for view in views:
        end = _end(view)
        if position is not None and end is not None and np.linalg.norm((end - position)[[0, 2]]) > FARTHEST:
            distance = np.linalg.norm((end - position)[[0, 2]])
            raise SampError(
                f"It is {distance:.0f} m from the character to its goal; move one of them nearer, "
                f"at most {FARTHEST:.0f} m{_unit_scale(context)}."
            )
        position = end if end is not None else position


def _end(view: SceneView) -> np.ndarray | None:
    if view.destination is not None:
        return view.destination[0]
    target = view.target
    return None if target is None else (target.min((0, 1)) + target.max((0, 1))) / 2


def _unit_scale(context: bpy.types.Context) -> str:
    """Return advice on the Unit Scale for an error message; empty where it is 1."""
    scale = context.scene.unit_settings.scale_length
    return "" if abs(scale - 1) < 1e-3 else f", and set the scene's Unit Scale of {scale:g} to 1"
