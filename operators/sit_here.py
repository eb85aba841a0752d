"""Sit Here: the character walks to the furniture and sits down."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from .job_operator import OptionsOperator

if TYPE_CHECKING:
    from ..samp_addon.pipeline.job import Job


class SAMP_OT_sit_here(OptionsOperator, bpy.types.Operator):
    """Walk to the selected furniture and sit down on it; each take becomes a new Action"""

    bl_idname = "samp.sit_here"
    bl_label = "Sit Here"

    def job(self, context: bpy.types.Context) -> Job:
        from ..samp_addon.blender.scene import targets
        from ..samp_addon.pipeline.job import Job

        return Job(
            action="sit", target=self.target or targets.clicked_target(context), **self.common(context)
        )
