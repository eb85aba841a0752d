"""Generate Takes: what the sidebar is set to, done."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from .job_operator import SettingsOperator

if TYPE_CHECKING:
    from ..samp_addon.pipeline.job import Job


class SAMP_OT_generate(SettingsOperator, bpy.types.Operator):
    """Do what is chosen, each take as a new Action; press again to see another way to do it"""

    bl_idname = "samp.generate"
    bl_label = "Generate Takes"

    @classmethod
    def why_not(cls, context: bpy.types.Context) -> str:
        from ..samp_addon.ui import job_from_settings

        return job_from_settings.why_not(context)

    def job(self, context: bpy.types.Context) -> Job:
        from ..samp_addon.ui import job_from_settings

        return job_from_settings.job(context)
