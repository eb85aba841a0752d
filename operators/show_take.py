"""Show Take: make a take the character's active Action."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty

from .take_operator import TakeOperator


class SAMP_OT_show_take(TakeOperator, bpy.types.Operator):
    """Make this take the character's active Action"""

    bl_idname = "samp.show_take"
    bl_label = "Show Take"

    fit: BoolProperty(
        name="Fit Frame Range",
        description="Set the scene's frame range to the take's",
        options={"SKIP_SAVE"},
    )

    explain: BoolProperty(
        name="Explain",
        description="Show the verdict on the take as the tooltip",
        options={"SKIP_SAVE", "HIDDEN"},
    )

    @classmethod
    def description(cls, context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        from ..samp_addon.blender.takes import judgement

        if properties.fit:
            return "Make this take the active Action and set the scene's frame range to its own"
        action = bpy.data.actions.get(properties.action_name)
        if not properties.explain or action is None:
            return cls.__doc__
        verdict, reason = judgement.judge(action)
        return f"{verdict.capitalize()}: {reason}"

    def on_take(self, context: bpy.types.Context, take: bpy.types.Action) -> str:
        from ..samp_addon.blender.takes import take_list

        take_list.show(context, self.owner(context), take, self.fit)
        return f"Showing '{take.name}'."
