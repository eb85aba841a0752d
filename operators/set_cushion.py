"""Soft Seat: how far a sofa or a bed yields under a body."""

from __future__ import annotations

import bpy
from bpy.props import FloatProperty

from . import outcome


class SAMP_OT_set_cushion(bpy.types.Operator):
    """Let the selected furniture yield under a body, so that a refined take sinks in a little"""

    bl_idname = "samp.set_cushion"
    bl_label = "Soft Seat"
    bl_options = {"REGISTER", "UNDO"}

    depth: FloatProperty(
        name="Depth",
        description="How far it yields; 0 for a hard seat",
        default=0.03,
        min=0.0,
        max=0.3,
        unit="LENGTH",
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.in_object_or_pose_mode(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._soften(context))

    def _soften(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.scene import cushions

        names = ", ".join(f"'{obj.name}'" for obj in cushions.set_cushion(context, self.depth))
        return f"{names}: a body sinks in by {self.depth * 100:.1f} cm."
