"""Which piece of furniture an artist means by a click."""

from __future__ import annotations

import bpy
import numpy as np

from ...errors import SampError
from ..overlays.goal_arrows import TARGET_KEY

LARGEST = 4.0
"""Metres across. A parent that holds more is not a piece of furniture but a part of the room."""


def clicked_target(context: bpy.types.Context) -> str:
    """The name of the furniture that is active or selected; for a goal's arrow its object.

    A click meets one cushion of a sofa whose parts hang under an empty: the target is the highest parent that
    is no larger than furniture is. Characters are passed over. Raises SampError where nothing fits.
    """
    active = context.view_layer.objects.active
    for thing in ([active] if active is not None else []) + list(context.selected_objects):
        if thing.get(TARGET_KEY):
            return thing[TARGET_KEY]
        if not _is_character(thing):
            return _whole(thing).name
    raise SampError("No furniture is selected; click it, or name a target.")


def _is_character(thing: bpy.types.Object) -> bool:
    return thing.type == "ARMATURE" or thing.find_armature() is not None


def _whole(thing: bpy.types.Object) -> bpy.types.Object:
    """The highest parent that is no larger than furniture."""
    while thing.parent and not _is_character(thing.parent) and _width(thing.parent) <= LARGEST:
        thing = thing.parent
    return thing


def _width(thing: bpy.types.Object) -> float:
    """Horizontal extent in metres of an object and all that hangs below it, by their bounding boxes."""
    corners = [
        np.array(part.matrix_world)[:2] @ np.append(np.array(corner), 1.0)
        for part in [thing, *thing.children_recursive]
        if part.type == "MESH"
        for corner in part.bound_box
    ]
    return float(np.ptp(np.array(corners), axis=0).max()) if corners else 0.0
