"""Which objects the sidebar's pointers to a character and to a piece of furniture offer."""

from __future__ import annotations

import bpy

from ...blender.scene import candidates


def is_character(settings: bpy.types.PropertyGroup, obj: bpy.types.Object) -> bool:
    """Return whether an object is an SMPL-X armature."""
    if obj.type != "ARMATURE":
        return False
    from ...blender.character import armature

    return armature.is_smplx(obj)


def is_target(settings: bpy.types.PropertyGroup, obj: bpy.types.Object) -> bool:
    """Return whether an object can be furniture."""
    return candidates.is_furniture(obj)
