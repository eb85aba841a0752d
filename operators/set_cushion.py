"""Soft Seat: set how far furniture yields under a body."""

from __future__ import annotations

import bpy
from bpy.props import FloatProperty

from . import outcome


class SAMP_OT_set_cushion(bpy.types.Operator):
    """Set how far the selected furniture yields under a body, so that refined takes sink in"""

    bl_idname = "samp.set_cushion"
    bl_label = "Soft Seat"
    bl_options = {"REGISTER", "UNDO"}

    depth: FloatProperty(
        name="Depth",
        description="Depth by which the seat yields; 0 for a hard seat",
        default=0.03,
        min=0.0,
        max=0.3,
        unit="LENGTH",
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        from ..samp_addon.blender.scene import candidates

        if not outcome.in_object_or_pose_mode(cls, context):
            return False
        if not candidates.selected(context):
            cls.poll_message_set("No furniture is selected; select the seat first")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._soften(context))

    def _soften(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.scene import cushions

        names = ", ".join(f"'{obj.name}'" for obj in cushions.set_cushion(context, self.depth))
        return f"Set the cushion depth of {names} to {self.depth * 100:.1f} cm."
