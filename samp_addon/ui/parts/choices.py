"""Which objects the sidebar's pointers to a character and to a piece of furniture offer."""

from __future__ import annotations

import bpy

from ...blender.scene import candidates


def is_character(settings: bpy.types.PropertyGroup, obj: bpy.types.Object) -> bool:
    """Return whether an object is an SMPL-X armature, or a rig that takes can be carried to."""
    if obj.type != "ARMATURE":
        return False
    from ...blender.rigs import performers

    return performers.is_performer(obj)


def is_target(settings: bpy.types.PropertyGroup, obj: bpy.types.Object) -> bool:
    """Return whether an object can be furniture."""
    return candidates.is_furniture(obj)
