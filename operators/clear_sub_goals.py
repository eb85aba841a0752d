"""Clear Sub-goals: delete all sub-goals of the character."""

from __future__ import annotations

import bpy

from . import outcome
from .sub_goal_operator import SubGoalOperator


class SAMP_OT_clear_sub_goals(SubGoalOperator, bpy.types.Operator):
    """Delete all sub-goals of the character and their bodies"""

    bl_idname = "samp.clear_sub_goals"
    bl_label = "Clear Sub-goals"

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._clear(context))

    def _clear(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.sub_goals import arrows, placing

        owner = arrows.owner_of(self._arrow(context))
        count = placing.clear(context, owner)
        return f"Cleared {count} sub-goal{'' if count == 1 else 's'}."
