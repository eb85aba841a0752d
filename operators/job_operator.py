"""Operators that bake a job: the job of their own options, or the one that the sidebar is set to."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, FloatProperty, FloatVectorProperty, IntProperty, StringProperty

from .thread_operator import ThreadOperator

if TYPE_CHECKING:
    from ..samp_addon.blender.takes.baking import Result
    from ..samp_addon.blender.thread_run import ThreadRun
    from ..samp_addon.pipeline.job import Job


class JobOperator(ThreadOperator):
    """Base of operators that bake the job that `job` returns."""

    def job(self, context: bpy.types.Context) -> Job:
        """Return the job. Raise SampError where what it needs is missing."""
        raise NotImplementedError

    def run_now(self, context: bpy.types.Context) -> Result:
        from ..samp_addon.blender.takes import baking

        return baking.run(context, self.job(context))

    def begin(self, context: bpy.types.Context) -> ThreadRun:
        from ..samp_addon.blender.takes import baking

        return baking.begin(context, self.job(context))

    def finished(self, result: Result) -> str:
        from ..samp_addon.blender.takes import baking

        return baking.sentence(result)


class OptionsOperator(JobOperator):
    """Base of operators whose job is in their own options: Sit Here, Lie Here, Walk Here."""

    target: StringProperty(
        name="Target",
        description="Object, empty or collection of the furniture; if empty, what is selected",
        options={"SKIP_SAVE"},
    )
    character: StringProperty(
        name="Character",
        description="SMPL-X armature; if empty, the selected one, the only one, or a new human",
        options={"SKIP_SAVE"},
    )
    seed: IntProperty(
        name="Seed",
        description="Seed of the random numbers; another one gives another take",
        default=0,
        min=0,
    )
    variants: IntProperty(name="Takes", description="Each is an Action of its own", default=1, min=1, max=64)
    hold: FloatProperty(
        name="Hold",
        description="Time to keep the final pose, in seconds",
        default=2.0,
        min=0.0,
        max=600.0,
        subtype="TIME_ABSOLUTE",
    )
    refine: BoolProperty(
        name="Refine", description="Correct contact, penetration and foot slide of each take; takes longer"
    )
    use_start: BoolProperty(
        name="Custom Start", description="Start elsewhere than where the character stands"
    )
    start: FloatVectorProperty(name="Start", description="Where to start", subtype="TRANSLATION", size=3)
    start_yaw: FloatProperty(
        name="Start Facing", description="Turn to the left from facing -Y, seen from above", subtype="ANGLE"
    )

    def common(self) -> dict:
        """Return the options that every job has."""
        start = (*self.start, math.degrees(self.start_yaw)) if self.use_start else None
        return {
            "character": self.character,
            "seed": self.seed,
            "variants": self.variants,
            "hold": self.hold,
            "refine": self.refine,
            "start": start,
        }


class SettingsOperator(JobOperator):
    """Base of operators whose job is what the sidebar is set to: Generate Takes, Bake Steps.

    `why_not` returns why there can be none now.
    """

    bl_options = {"UNDO"}

    @classmethod
    def why_not(cls, context: bpy.types.Context) -> str:
        """Return why there can be no job now; empty where there can be one."""
        raise NotImplementedError

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not super().poll(context):
            return False
        reason = cls.why_not(context)
        if reason:
            cls.poll_message_set(reason)
        return not reason

    def finished(self, result: Result) -> str:
        scene = bpy.context.scene
        settings = scene.samp
        # The next press shows another way to do it.
        settings.seed = (settings.seed + settings.variants) % 2**31
        settings.character = settings.character or result.owner
        if settings.fit_range:
            scene.frame_end = max(scene.frame_end, *(variant["frame_end"] for variant in result.variants))
        return super().finished(result)
