"""Turns the sidebar's settings into the jobs that are sent to a farm, by the code of the buttons that bake here."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import bpy

from ...blender.scene import candidates
from ...errors import SampError
from ...vocabulary import SEATED
from .. import job_from_settings
from ..cast import jobs as cast_jobs

if TYPE_CHECKING:
    from ...pipeline.cast.cast import Cast
    from ...pipeline.job import Job


def why_not(context: bpy.types.Context) -> str:
    """Return why there is nothing to send; empty where there is."""
    settings = context.scene.samp
    if settings.farm.what == "STEPS":
        return "" if len(settings.steps) else "Add a step first"
    if settings.farm.what == "CAST":
        return cast_jobs.why_not(context)
    return job_from_settings.why_not(context)


def of_settings(context: bpy.types.Context) -> list[Job | Cast]:
    """Return the jobs that the settings ask for, as the batch has to have them. Raise SampError."""
    from ...blender.takes import for_batch

    settings = context.scene.samp
    if settings.farm.what == "STEPS":
        found = [job_from_settings.job_of_steps(context)]
    elif settings.farm.what == "CAST":
        found = [cast_jobs.of_list(context, job_from_settings.common(settings))]
    else:
        found = _takes(context)
    return [for_batch.resolved(context, job, settings.start_from) for job in found]


def _takes(context: bpy.types.Context) -> list[Job | Cast]:
    """Return the jobs of the generate button, one for each selected piece of furniture if asked for."""
    cast = job_from_settings.cast(context)
    if cast is not None:
        return [cast]
    job = job_from_settings.job(context)
    if not context.scene.samp.farm.each_selected or job.action not in SEATED:
        return [job]
    from ...blender.scene import targets

    names = dict.fromkeys(targets.whole(obj).name for obj in candidates.selected(context))
    if not names:
        raise SampError(
            f"{candidates.why_none(context)}; select furniture, or turn off Each Selected Object."
        )
    return [replace(job, target=name) for name in names]
