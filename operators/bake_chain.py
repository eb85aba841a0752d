"""Bake Steps: all steps of the sidebar as one take."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from .job_operator import SettingsOperator

if TYPE_CHECKING:
    from ..samp_addon.pipeline.job import Job


class SAMP_OT_bake_chain(SettingsOperator, bpy.types.Operator):
    """Generate one take of all steps in order, as a new Action"""

    bl_idname = "samp.bake_chain"
    bl_label = "Bake Steps"

    @classmethod
    def why_not(cls, context: bpy.types.Context) -> str:
        return "" if context.scene.samp.steps else "Add a step first"

    def job(self, context: bpy.types.Context) -> Job:
        from ..samp_addon.ui import job_from_settings

        return job_from_settings.job_of_steps(context)
