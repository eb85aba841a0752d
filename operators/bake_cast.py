"""Bake Cast: all characters of the sidebar's cast at the same time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from .job_operator import SettingsOperator

if TYPE_CHECKING:
    from ..samp_addon.pipeline.cast.cast import Cast


class SAMP_OT_bake_cast(SettingsOperator, bpy.types.Operator):
    """Generate takes of all characters of the cast, which keep clear of each other; each becomes a new Action"""

    bl_idname = "samp.bake_cast"
    bl_label = "Bake Cast"

    @classmethod
    def why_not(cls, context: bpy.types.Context) -> str:
        from ..samp_addon.ui.cast import jobs

        return jobs.why_not(context)

    def job(self, context: bpy.types.Context) -> Cast:
        from ..samp_addon.ui import job_from_settings
        from ..samp_addon.ui.cast import jobs

        return jobs.of_list(context, job_from_settings.common(context.scene.samp))
