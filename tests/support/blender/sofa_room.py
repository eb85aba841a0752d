"""A human in a small room with a sofa."""

from __future__ import annotations

import bpy
import rooms


def build(fps: int = 30) -> bpy.types.Object:
    """Build the room in an empty file and return the human's armature. fps: of the scene."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.context.scene.render.fps = fps
    start = rooms.to_blender(rooms.random_room(1, rooms.sofa), bpy.context.scene)
    bpy.context.view_layer.update()
    bpy.ops.samp.create_character(location=tuple(start[:3]), yaw=1.0)
    return bpy.data.objects["Human"]
