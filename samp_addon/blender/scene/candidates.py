"""Which objects can be furniture. Called at every redraw: import nothing heavy here."""

from __future__ import annotations

import bpy
from mathutils import Vector

NO_FURNITURE = frozenset({"ARMATURE", "CAMERA", "LIGHT", "LIGHT_PROBE", "SPEAKER"})

OVERLAY_KEY = "samp_overlay"
"""Custom property of overlay objects of this add-on; they are never part of the scene."""

THIN, WIDE = 0.15, 2.5
"""Metres: an object that is thinner than THIN and wider than WIDE in both directions is a floor, not furniture."""


def is_furniture(obj: bpy.types.Object) -> bool:
    """Return whether an object can be a target: not a character, light, camera or speaker, and not a floor."""
    if obj.get(OVERLAY_KEY):
        return bool(obj.get("samp_goal_target"))  # a goal's arrow stands for the furniture that it is on
    return obj.type not in NO_FURNITURE and obj.find_armature() is None and not is_floor(obj)


def is_floor(obj: bpy.types.Object) -> bool:
    """Return whether an object without children is as flat and wide as a floor or a ceiling."""
    if obj.type != "MESH":
        return False
    corners = [obj.matrix_world @ Vector(corner) for corner in obj.bound_box]
    sizes = [max(corner[k] for corner in corners) - min(corner[k] for corner in corners) for k in range(3)]
    return sizes[2] < THIN and min(sizes[:2]) > WIDE and not obj.children


def selected(context: bpy.types.Context) -> list[bpy.types.Object]:
    """Return the active and the selected objects that can be furniture, the active one first."""
    active = context.view_layer.objects.active
    others = [obj for obj in context.selected_objects if obj != active]
    return [obj for obj in ([active] if active is not None else []) + others if is_furniture(obj)]


def why_none(context: bpy.types.Context) -> str:
    """Return why nothing that is selected can be a target."""
    active = context.view_layer.objects.active
    if active is not None and is_floor(active):
        return f"'{active.name}' is a floor"
    if active is not None and active.type in NO_FURNITURE - {"ARMATURE"}:
        return f"'{active.name}' is not furniture"
    return "No furniture is selected"
