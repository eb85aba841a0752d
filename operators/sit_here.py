"""Sit Here: the character walks to the furniture and sits down."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from .job_operator import OptionsOperator
from .pick_point import PickPoint

if TYPE_CHECKING:
    from ..samp_addon.pipeline.cast.cast import Cast
    from ..samp_addon.pipeline.job import Job


class SAMP_OT_sit_here(PickPoint, OptionsOperator, bpy.types.Operator):
    """Walk to the selected furniture and sit down on it; several selected characters take places of their own"""

    bl_idname = "samp.sit_here"
    bl_label = "Sit Here"

    def target_name(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.scene import targets

        return self.target or targets.clicked_target(context)

    def job(self, context: bpy.types.Context) -> Job | Cast:
        from ..samp_addon.pipeline.job import Job

        cast = self.cast(context, "sit")
        if cast is not None:
            return cast
        target = self.target_name(context)
        return Job(action="sit", target=target, point=self.point(), **self.common(context))
