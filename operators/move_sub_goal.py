"""Move Sub-goal: change the order in which the take passes the sub-goals."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty

from .sub_goal_operator import SubGoalOperator


class SAMP_OT_move_sub_goal(SubGoalOperator, bpy.types.Operator):
    """Move the active sub-goal up or down in the order of the take"""

    bl_idname = "samp.move_sub_goal"
    bl_label = "Move Sub-goal"

    direction: EnumProperty(
        name="Direction",
        description="Where to move the sub-goal in the list",
        items=(
            ("UP", "Up", "Pass the sub-goal before the one above it"),
            ("DOWN", "Down", "Pass the sub-goal after the one below it"),
        ),
    )

    @classmethod
    def description(cls, context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        return cls.bl_rna.properties["direction"].enum_items[properties.direction].description

    @classmethod
    def why_not(cls, context: bpy.types.Context, arrow: bpy.types.Object) -> str:
        from ..samp_addon.blender.sub_goals import arrows

        count = len(arrows.listed(context, arrows.owner_of(arrow)))
        return "" if count > 1 else "There is only one sub-goal; add another one first"

    def on_sub_goal(self, context: bpy.types.Context, arrow: bpy.types.Object) -> str:
        from ..samp_addon.blender.sub_goals import arrows
        from ..samp_addon.ui import sub_goal_settings

        arrows.move(context, arrow, 1 if self.direction == "DOWN" else -1)
        sub_goal_settings.activate(context, arrow)
        return ""
