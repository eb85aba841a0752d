"""What no take can be made for, told before any work is done."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from ...errors import SampError
from ...methods.scene_view import SceneView
from ..actions import keyframes
from ..character import armature

HEIGHTS = (0.5, 3.5)
"""Metres from sole to head joint of a person. Who is larger was made in centimetres, or feet."""

LARGEST = 12.0
"""Metres of a piece of furniture, where the scene's units are not metres."""

FARTHEST = 250.0
"""Metres to walk in one take; a navmesh over more is too coarse to walk on."""


def refuse(context: bpy.types.Context, owner: bpy.types.Object | None, views: Sequence[SceneView]) -> None:
    """Raises SampError where the character cannot have an Action, is no person's size, or has too far to go."""
    if owner is not None:
        keyframes.refuse_locked(owner)
        _refuse_size(context, owner)
    _refuse_units(context, views)
    _refuse_distance(context, views)


def refuse_writing(context: bpy.types.Context, owner: bpy.types.Object | None) -> None:
    """Raises SampError where a finished take cannot be written, by what the artist has done since it was begun."""
    if owner is not None:
        keyframes.refuse_locked(owner)
    elif context.mode not in ("OBJECT", "POSE"):
        raise SampError("A new character cannot be made while you edit; go to Object Mode and start again.")


def _refuse_size(context: bpy.types.Context, owner: bpy.types.Object) -> None:
    rest = armature.calibrate(owner).rest_joints
    height = float(np.ptp(rest[:, 1]))
    if not HEIGHTS[0] <= height <= HEIGHTS[1]:
        raise SampError(
            f"'{owner.name}' is {height:.2g} units tall, and a unit is a metre here; "
            f"scale it and the room to metres{_unit_scale(context)}."
        )


def _refuse_units(context: bpy.types.Context, views: Sequence[SceneView]) -> None:
    """Furniture that is a house by its numbers, in a scene whose units are not metres."""
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


def _refuse_distance(context: bpy.types.Context, views: Sequence[SceneView]) -> None:
    """The way from each step's start to where it leads."""
    start = views[0].start
    place = None if start is None else start[0]
    for view in views:
        end = _end(view)
        if place is not None and end is not None and np.linalg.norm((end - place)[[0, 2]]) > FARTHEST:
            away = np.linalg.norm((end - place)[[0, 2]])
            raise SampError(
                f"It is {away:.0f} m from the character to where it shall go; move one of them nearer, "
                f"at most {FARTHEST:.0f} m{_unit_scale(context)}."
            )
        place = end if end is not None else place


def _end(view: SceneView) -> np.ndarray | None:
    if view.destination is not None:
        return view.destination[0]
    target = view.target
    return None if target is None else (target.min((0, 1)) + target.max((0, 1))) / 2


def _unit_scale(context: bpy.types.Context) -> str:
    """What to do beside it in a scene whose units are not metres."""
    scale = context.scene.unit_settings.scale_length
    return "" if abs(scale - 1) < 1e-3 else f", and set the scene's Unit Scale of {scale:g} to 1"
