"""Generate Takes: run the job of the sidebar's settings."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import bpy

from ..samp_addon.vocabulary import SEATED
from .job_operator import SettingsOperator
from .pick_point import PickPoint

if TYPE_CHECKING:
    from ..samp_addon.pipeline.cast.cast import Cast
    from ..samp_addon.pipeline.job import Job


class SAMP_OT_generate(PickPoint, SettingsOperator, bpy.types.Operator):
    """Generate takes with the current settings; each becomes a new Action"""

    bl_idname = "samp.generate"
    bl_label = "Generate Takes"

    @classmethod
    def why_not(cls, context: bpy.types.Context) -> str:
        from ..samp_addon.ui import job_from_settings

        return job_from_settings.why_not(context)

    def label(self, context: bpy.types.Context) -> str:
        from ..samp_addon.ui import job_from_settings

        return job_from_settings.button_label(context)

    def method_used(self, context: bpy.types.Context) -> str:
        return context.scene.samp.method

    def job(self, context: bpy.types.Context) -> Job | Cast:
        from ..samp_addon.ui import job_from_settings

        cast = job_from_settings.cast(context)
        if cast is not None:
            return cast
        return replace(job_from_settings.job(context), point=self.point())

    def target_name(self, context: bpy.types.Context) -> str:
        from ..samp_addon.ui import job_from_settings

        job = job_from_settings.job(context)
        return job.target if job.action in SEATED else ""
