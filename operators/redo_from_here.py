"""Redo From Here: another end for the same beginning of a take."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, IntProperty

from .take_operator import TakeOperator
from .thread_operator import ThreadOperator

if TYPE_CHECKING:
    from ..samp_addon.blender.edits.redo import Redone
    from ..samp_addon.blender.thread_run import ThreadRun


class SAMP_OT_redo_from_here(ThreadOperator, TakeOperator, bpy.types.Operator):
    """Generate another end of this take from the current frame on; all frames before stay exactly as they are"""

    bl_idname = "samp.redo_from_here"
    bl_label = "Redo From Here"

    use_frame: BoolProperty(
        name="Custom Frame", description="Begin at another frame than the current one", options={"SKIP_SAVE"}
    )
    frame: IntProperty(name="Frame", description="Last frame that stays", default=1)
    seed: IntProperty(
        name="Seed",
        description="Seed of the new end; if -1, one more than the take's",
        default=-1,
        min=-1,
        options={"SKIP_SAVE"},
    )

    def arguments(self, context: bpy.types.Context) -> tuple:
        """Return the arguments of redo.run and begin."""
        frame = self.frame if self.use_frame else None
        seed = None if self.seed < 0 else self.seed
        return context, self.owner(context), self.take(context), frame, seed

    def run_now(self, context: bpy.types.Context) -> Redone:
        from ..samp_addon.blender.edits import redo

        return redo.run(*self.arguments(context))

    def begin(self, context: bpy.types.Context) -> ThreadRun:
        from ..samp_addon.blender.edits import redo

        return redo.begin(*self.arguments(context))

    def finished(self, result: Redone) -> str:
        return result.sentence()
