"""Use Current Pose: the character's own pose becomes the body of a sub-goal."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty

from .sub_goal_operator import SubGoalOperator


class SAMP_OT_use_current_pose(SubGoalOperator, bpy.types.Operator):
    """Make the character's current pose the body of the active sub-goal, and pin it"""

    bl_idname = "samp.use_current_pose"
    bl_label = "Use Current Pose"

    here: BoolProperty(
        name="Move Here",
        description="Move the sub-goal to where the character is now",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def why_not(cls, context: bpy.types.Context, arrow: bpy.types.Object) -> str:
        from ..samp_addon.blender.sub_goals import arrows

        return "" if arrows.owner_of(arrow) is not None else f"The character of '{arrow.name}' was deleted"

    def on_sub_goal(self, context: bpy.types.Context, arrow: bpy.types.Object) -> str:
        from ..samp_addon.blender.sub_goals import placing

        placing.use_pose(context, arrow, self.here)
        return f"'{arrow.name}' has the pose of the character now."
