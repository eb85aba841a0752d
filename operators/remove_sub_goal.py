"""Remove Sub-goal: delete a sub-goal and its body."""

from __future__ import annotations

import bpy

from .sub_goal_operator import SubGoalOperator


class SAMP_OT_remove_sub_goal(SubGoalOperator, bpy.types.Operator):
    """Delete the active sub-goal and its body"""

    bl_idname = "samp.remove_sub_goal"
    bl_label = "Remove Sub-goal"

    def on_sub_goal(self, context: bpy.types.Context, arrow: bpy.types.Object) -> str:
        from ..samp_addon.blender.sub_goals import placing

        name = arrow.name
        placing.remove(context, arrow)
        return f"Removed '{name}'."
