"""Follow: a take goes to where its target, goal or way-point was dragged."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from .take_operator import TakeOperator
from .thread_operator import ThreadOperator

if TYPE_CHECKING:
    from ..samp_addon.blender.edits.redo import Redone
    from ..samp_addon.blender.thread_run import ThreadRun


class SAMP_OT_follow_goal(ThreadOperator, TakeOperator, bpy.types.Operator):
    """Generate this take again from where a moved target, goal or way-point first matters; frames before that stay"""

    bl_idname = "samp.follow_goal"
    bl_label = "Follow"

    def run_now(self, context: bpy.types.Context) -> Redone:
        from ..samp_addon.blender.edits import following

        return following.run(context, self.owner(context), self.take(context))

    def begin(self, context: bpy.types.Context) -> ThreadRun:
        from ..samp_addon.blender.edits import following

        return following.begin(context, self.owner(context), self.take(context))

    def finished(self, result: Redone) -> str:
        return result.sentence()
