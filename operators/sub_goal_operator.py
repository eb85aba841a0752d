"""Base of the operators on sub-goals: the sub-goal and its character, and why there is none."""

from __future__ import annotations

import bpy
from bpy.props import StringProperty

from ..samp_addon.blender import running_work
from . import outcome

METHOD = "long_term"


class SubGoalOperator:
    """Base class; subclasses implement `on_sub_goal`, and `why_not` where more than a sub-goal is needed."""

    bl_options = {"REGISTER", "UNDO"}

    sub_goal: StringProperty(
        name="Sub-goal",
        description="Arrow of the sub-goal; if empty, the active one",
        options={"SKIP_SAVE"},
    )

    def on_sub_goal(self, context: bpy.types.Context, arrow: bpy.types.Object) -> str:
        """Do the work on a sub-goal and return the message to report."""
        raise NotImplementedError

    @classmethod
    def why_not(cls, context: bpy.types.Context, arrow: bpy.types.Object) -> str:
        """Return why the work cannot be done on the active sub-goal; empty where it can."""
        return ""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        from ..samp_addon.ui import sub_goal_settings

        if not can_place(cls, context):
            return False
        arrow = sub_goal_settings.current(context)
        reason = "There is no sub-goal; add one first" if arrow is None else cls.why_not(context, arrow)
        if reason:
            cls.poll_message_set(reason)
        return not reason

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self.on_sub_goal(context, self._arrow(context)))

    def _arrow(self, context: bpy.types.Context) -> bpy.types.Object:
        """Return the sub-goal. Raise SampError where there is none."""
        from ..samp_addon.blender.sub_goals import arrows
        from ..samp_addon.ui import sub_goal_settings

        return arrows.find(context, self.sub_goal) if self.sub_goal else sub_goal_settings.current(context)


def can_place(operator: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """Return whether the method of sub-goals is there and the mode fits; otherwise the tooltip gives the reason."""
    from ..samp_addon.ui import method_options

    if not method_options.offered(METHOD):
        operator.poll_message_set("The networks of Long-term are not installed")
        return False
    work = running_work.current()
    if work is not None:
        operator.poll_message_set(f"Wait until '{work.label}' is done, or cancel it")
        return False
    return outcome.in_object_or_pose_mode(operator, context)
