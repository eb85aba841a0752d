"""Pin Body: keep the body of a sub-goal."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty

from .sub_goal_operator import SubGoalOperator


class SAMP_OT_pin_body(SubGoalOperator, bpy.types.Operator):
    """Keep the pose of the active sub-goal's body, also when its arrow is moved; press again to let it change"""

    bl_idname = "samp.pin_body"
    bl_label = "Pin Body"

    state: EnumProperty(
        name="State",
        description="Whether the body is kept",
        items=(
            ("TOGGLE", "Toggle", "Pin an unpinned body, unpin a pinned one"),
            ("PIN", "Pin", "Keep the body"),
            ("UNPIN", "Unpin", "Let the body be drawn again"),
        ),
        options={"SKIP_SAVE"},
    )

    def on_sub_goal(self, context: bpy.types.Context, arrow: bpy.types.Object) -> str:
        from ..samp_addon.blender.sub_goals import stored

        pinned = not stored.is_pinned(arrow) if self.state == "TOGGLE" else self.state == "PIN"
        stored.pin(arrow, pinned)
        return f"{'Pinned' if pinned else 'Unpinned'} the body of '{arrow.name}'."
