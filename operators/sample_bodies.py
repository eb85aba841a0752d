"""Another Body: draw the next body of a sub-goal."""

from __future__ import annotations

import bpy

from .sub_goal_operator import SubGoalOperator


class SAMP_OT_sample_bodies(SubGoalOperator, bpy.types.Operator):
    """Draw another body for the active sub-goal; Style says how much bodies differ"""

    bl_idname = "samp.sample_bodies"
    bl_label = "Another Body"

    @classmethod
    def why_not(cls, context: bpy.types.Context, arrow: bpy.types.Object) -> str:
        from ..samp_addon.blender.sub_goals import stored

        return f"The body of '{arrow.name}' is pinned; unpin it first" if stored.is_pinned(arrow) else ""

    def on_sub_goal(self, context: bpy.types.Context, arrow: bpy.types.Object) -> str:
        from ..samp_addon.blender.sub_goals import placing

        placing.another(context, arrow, round(context.scene.samp.style, 4))
        return ""
