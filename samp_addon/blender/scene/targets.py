"""Finds the piece of furniture that an artist has clicked."""

from __future__ import annotations

import bpy
import numpy as np

from ...errors import SampError
from ..overlays.goal_arrows import TARGET_KEY
from . import pieces

LARGEST = 4.0
"""Largest width of furniture in metres; a larger parent is a part of the room."""


def clicked_target(context: bpy.types.Context) -> str:
    """Return the name of the furniture that is active or selected; for a goal's arrow, its target.

    A click selects one cushion of a sofa whose parts have a common parent: the target is the highest parent
    of furniture size. Characters, lights, cameras and floors are skipped. Raise SampError where nothing fits.
    """
    active = context.view_layer.objects.active
    for obj in ([active] if active is not None else []) + list(context.selected_objects):
        if obj.get(TARGET_KEY):
            return obj[TARGET_KEY]
        if pieces.is_furniture(obj):
            return _whole(obj).name
    raise SampError(f"{pieces.why_none(context)}; select furniture, or choose a target.")


def _is_character(obj: bpy.types.Object) -> bool:
    return obj.type == "ARMATURE" or obj.find_armature() is not None


def _whole(obj: bpy.types.Object) -> bpy.types.Object:
    """Return the highest parent of furniture size."""
    while obj.parent and not _is_character(obj.parent) and _width(obj.parent) <= LARGEST:
        obj = obj.parent
    return obj


def _width(obj: bpy.types.Object) -> float:
    """Return the horizontal extent in metres of an object and its children, from bounding boxes."""
    corners = [
        np.array(part.matrix_world)[:2] @ np.append(np.array(corner), 1.0)
        for part in [obj, *obj.children_recursive]
        if part.type == "MESH"
        for corner in part.bound_box
    ]
    return float(np.ptp(np.array(corners), axis=0).max()) if corners else 0.0
