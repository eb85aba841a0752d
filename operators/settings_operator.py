"""What Generate Takes and Bake Chain have in common: a job that the sidebar is set to."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from .thread_operator import ThreadOperator

if TYPE_CHECKING:
    from ..samp_addon.blender.takes.baking import Result
    from ..samp_addon.blender.thread_run import ThreadRun
    from ..samp_addon.pipeline.job import Job


class SettingsOperator(ThreadOperator):
    """The operator has `job`, and `why_not`, which says why there can be none now."""

    bl_options = {"UNDO"}

    @classmethod
    def why_not(cls, context: bpy.types.Context) -> str:
        """Empty where there can be a job."""
        raise NotImplementedError

    def job(self, context: bpy.types.Context) -> Job:
        """The job. Raises SampError where what it needs is missing."""
        raise NotImplementedError

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not super().poll(context):
            return False
        reason = cls.why_not(context)
        if reason:
            cls.poll_message_set(reason)
        return not reason

    def at_once(self, context: bpy.types.Context) -> Result:
        from ..samp_addon.blender.takes import baking

        return baking.run(context, self.job(context))

    def begin(self, context: bpy.types.Context) -> ThreadRun:
        from ..samp_addon.blender.takes import baking

        return baking.begin(context, self.job(context))

    def told(self, result: Result) -> str:
        from ..samp_addon.blender.takes import baking

        scene = bpy.context.scene
        settings = scene.samp
        # The next press shows another way to do it.
        settings.seed = (settings.seed + settings.variants) % 2**31
        settings.character = settings.character or result.owner
        if settings.fit_range:
            scene.frame_end = max(scene.frame_end, *(variant["frame_end"] for variant in result.variants))
        return baking.sentence(result)
