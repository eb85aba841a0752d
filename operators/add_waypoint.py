"""Add Way-point: a point at the 3D cursor that the path passes."""

from __future__ import annotations

import bpy

from . import outcome


class SAMP_OT_add_waypoint(bpy.types.Operator):
    """Add a way-point at the 3D cursor, which the path of the next take passes; it can be moved like any object"""

    bl_idname = "samp.add_waypoint"
    bl_label = "Add Way-point"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.in_object_or_pose_mode(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._add(context))

    def _add(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.overlays import waypoints

        return f"Added '{waypoints.add(context, context.scene.cursor.location).name}'."
