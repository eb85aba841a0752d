"""Cushion depth: how far furniture yields under a body."""

from __future__ import annotations

import bpy

from ...errors import SampError
from .read_scene import CUSHION_KEY, SURFACE_TYPES

SOFT = 0.03
"""Default depth in metres, for a sofa or a bed."""

DEEPEST = 0.3
"""Upper limit of the depth in the interface, metres."""


def set_cushion(context: bpy.types.Context, depth: float = SOFT) -> list[bpy.types.Object]:
    """Set the cushion depth in metres of each selected piece of furniture, or the active one; return them.

    Characters are skipped. Raise SampError where there is no such object, or one cannot be changed.
    """
    chosen = furniture(context)
    if not chosen:
        raise SampError("No furniture is selected; select the seat to soften.")
    for obj in chosen:
        if not obj.is_editable:
            raise SampError(f"'{obj.name}' is linked from another file; make a library override of it first.")
    for obj in chosen:
        obj[CUSHION_KEY] = float(depth)
        obj.id_properties_ui(CUSHION_KEY).update(
            min=0.0,
            max=DEEPEST,
            default=0.0,
            subtype="DISTANCE",
            description="How far the seat yields under a body",
        )
        obj.update_tag()
    return chosen


def furniture(context: bpy.types.Context) -> list[bpy.types.Object]:
    """Return the selected objects with a surface, or else the active one; never characters."""
    active = context.view_layer.objects.active
    chosen = [obj for obj in context.selected_objects if _is_furniture(obj)]
    return chosen or [obj for obj in (active,) if obj is not None and _is_furniture(obj)]


def _is_furniture(obj: bpy.types.Object) -> bool:
    return (obj.type in SURFACE_TYPES or obj.instance_type == "COLLECTION") and obj.find_armature() is None
