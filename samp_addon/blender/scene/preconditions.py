"""Checks that a take can be made, before any work is done."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from ...errors import SampError
from ...methods.scene_view import SceneView
from ...scene import geometry
from ..actions import keyframes
from ..rigs import performers
from .open_scene import CONVERTED_KEY

HEIGHTS = (0.5, 3.5)
"""Plausible metres from sole to head joint; larger characters were modelled in centimetres or feet."""

LARGEST = 12.0
"""Largest plausible extent of furniture in metres, checked where the scene's unit is not the metre."""

FLAT, LEAST_STOREY = 2.0, 4.0
"""How much wider and taller than deep a scene on its side is at least, and its least height in metres."""

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
    height = performers.height(owner)
    if not HEIGHTS[0] <= height <= HEIGHTS[1]:
        raise SampError(
            f"'{owner.name}' is {height:.2g} units tall, and a unit is a metre here; "
            f"scale it and the room to metres{_unit_scale(context)}."
        )


def _check_units(context: bpy.types.Context, views: Sequence[SceneView]) -> None:
    """Raise SampError for furniture as large as a house, where the scene's unit is not the metre or is not known.

    An imported file says nothing of its units and axes. A house can be the target of a walk in a .blend.
    """
    imported = not bpy.data.filepath and not context.scene.get(CONVERTED_KEY)
    for view in views:
        target = view.target
        if target is None:
            continue
        size = np.ptp(target, axis=(0, 1))
        tall = imported and size[1] > LARGEST
        if size.max() > LARGEST and (_unit_scale(context) or tall):
            unit = "mm" if size.max() > 600 else "cm"
            words = {"mm": "millimetres", "cm": "centimetres"}[unit]
            advice = f" (for the batch: --units {unit})" if imported else ""
            raise SampError(
                f"The furniture is {size.max():.0f} units large, and a unit is a metre here; the scene is probably in "
                f"{words}, so scale it and the room to metres{advice}{_unit_scale(context)}."
            )
    if imported and views and _on_its_side(views[0].geometry.triangles):
        raise SampError(
            "The scene lies on its side: its floor stands upright; turn it by 90 degrees about X (for the batch: "
            "--up Z, or --up Y if it is right)."
        )


def _on_its_side(triangles: np.ndarray) -> bool:
    """Return whether a scene (F, 3, 3) is flat along Blender's Y axis, and most of its surface faces that way."""
    if len(triangles) == 0:
        return False
    size = np.subtract(*geometry.extent(triangles)[::-1])
    if size[2] * FLAT > min(size[0], size[1]) or size[1] < LEAST_STOREY:
        return False
    area = np.abs(geometry.area_vectors(triangles)).sum(axis=0)
    return bool(area[2] > 1.05 * area[1])


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
