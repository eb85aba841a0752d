"""Operators that bake a job: the job of their own options, or the one that the sidebar is set to."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, FloatProperty, FloatVectorProperty, IntProperty, StringProperty

from ..samp_addon.blender.character import measures
from .thread_operator import ThreadOperator

if TYPE_CHECKING:
    from ..samp_addon.blender.cast.baking import CastResult
    from ..samp_addon.blender.takes.baking import Result
    from ..samp_addon.blender.thread_run import ThreadRun
    from ..samp_addon.pipeline.cast.cast import Cast
    from ..samp_addon.pipeline.job import Job


def _saved_never(kind: object, **options: object) -> object:
    """Return a property that is unset at every press, so that the sidebar's setting applies."""
    return kind(**options, options={"SKIP_SAVE"})


class JobOperator(ThreadOperator):
    """Base of operators that bake the job that `job` returns."""

    def job(self, context: bpy.types.Context) -> Job | Cast:
        """Return the job, or the cast of several characters. Raise SampError where what it needs is missing."""
        raise NotImplementedError

    def seed_given(self) -> bool:
        """Return whether the caller chose the seed; otherwise the sidebar's seed is used and increased."""
        return False

    def fits_range(self) -> bool:
        """Return whether the setting Fit Frame Range applies: to buttons, not to the calls of a script."""
        return self._run is not None

    def run_now(self, context: bpy.types.Context) -> Result | CastResult:
        from ..samp_addon.blender.cast import baking as cast_baking
        from ..samp_addon.blender.takes import baking
        from ..samp_addon.pipeline.cast.cast import Cast

        job = self.job(context)
        if isinstance(job, Cast):
            return cast_baking.run(context, job, from_markers=True)
        return baking.run(context, job, start_from=context.scene.samp.start_from)

    def begin(self, context: bpy.types.Context) -> ThreadRun:
        from ..samp_addon.blender.cast import baking as cast_baking
        from ..samp_addon.blender.takes import baking
        from ..samp_addon.pipeline.cast.cast import Cast

        job = self.job(context)
        if isinstance(job, Cast):
            return cast_baking.begin(context, job, from_markers=True)
        return baking.begin(context, job, start_from=context.scene.samp.start_from)

    def finished(self, result: Result | CastResult) -> str:
        from ..samp_addon.blender.cast import baking as cast_baking
        from ..samp_addon.blender.edits import after_baking
        from ..samp_addon.blender.takes import baking

        scene = bpy.context.scene
        settings = scene.samp
        if not self.seed_given():
            seeds = len(result.variants) + len(result.failures)
            settings.seed = (settings.seed + seeds) % 2**31  # the next press gives another take
        several = isinstance(result, cast_baking.CastResult)
        if not several:
            settings.character = settings.character or result.owner
        strips = after_baking.apply(bpy.context, result.takes, settings.mark_takes, settings.as_strip)
        if settings.fit_range and self.fits_range():
            ends = [strip.frame_end for strip in strips] or [take["frame_end"] for take in result.variants]
            scene.frame_end = round(max(ends))
        return cast_baking.sentence(result) if several else baking.sentence(result)


class OptionsOperator(JobOperator):
    """Base of Sit Here, Lie Here and Walk Here. Options that the caller does not give are the sidebar's settings."""

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
    seed: _saved_never(
        IntProperty,
        name="Seed",
        description="Seed of the random numbers; another one gives another take",
        min=0,
    )
    variants: _saved_never(
        IntProperty, name="Takes", description="Number of takes; each is an Action", default=1, min=1, max=64
    )
    style: _saved_never(
        FloatProperty,
        name="Style",
        description="Amount of variation between takes",
        default=0.1,
        min=0.0,
        max=1.0,
    )
    speed: _saved_never(
        FloatProperty,
        name="Speed",
        description="Speed relative to captured motion",
        default=1.0,
        min=0.5,
        max=2.0,
    )
    hold: _saved_never(
        FloatProperty,
        name="Hold",
        description="Time to keep the final pose, in seconds",
        default=2.0,
        min=0.0,
        max=600.0,
        subtype="TIME_ABSOLUTE",
    )
    refine: _saved_never(
        BoolProperty,
        name="Refine",
        description="Correct contact, penetration and foot slide of each take; takes longer",
    )
    use_start: _saved_never(
        BoolProperty, name="Custom Start", description="Start elsewhere than at the start marker"
    )
    start: FloatVectorProperty(name="Start", description="Where to start", subtype="TRANSLATION", size=3)
    start_yaw: FloatProperty(
        name="Start Facing", description="Turn to the left from facing -Y, seen from above", subtype="ANGLE"
    )
    __annotations__ |= measures.of_operator(options={"SKIP_SAVE"})

    def seed_given(self) -> bool:
        return self.properties.is_property_set("seed")

    def cast(
        self, context: bpy.types.Context, action: str, to: tuple[float, ...] | None = None
    ) -> Cast | None:
        """Return the cast of the selected characters, each on a place of its own; None unless there are several.

        to: where they walk without a target.
        """
        from ..samp_addon.ui.cast import jobs

        if self.character:
            return None
        return jobs.of_selection(context, action, self.common(context), self.target, to)

    def common(self, context: bpy.types.Context) -> dict:
        """Return the options that every job has."""
        from ..samp_addon.ui import job_from_settings

        chosen = job_from_settings.common(context.scene.samp)
        own = [name for name in chosen if name != "shape"]
        given = {name: getattr(self, name) for name in own if self.properties.is_property_set(name)}
        if given.get("character"):
            chosen["shape"] = {}
        for name in measures.LIMITS:
            if self.properties.is_property_set(name):
                chosen["shape"][name] = round(getattr(self, name), 4)
        chosen["shape"] = {
            name: value for name, value in chosen["shape"].items() if measures.is_set(name, value)
        }
        start = (*self.start, math.degrees(self.start_yaw)) if self.use_start else None
        return chosen | given | {"start": start}


class SettingsOperator(JobOperator):
    """Base of operators whose job is what the sidebar is set to: Generate Takes, Bake Steps.

    `why_not` returns why there can be none now.
    """

    def fits_range(self) -> bool:
        return True

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
