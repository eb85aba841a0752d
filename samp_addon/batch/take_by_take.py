"""A job of the batch, done in pieces that are kept: the takes of one rollout, then one refinement after the other.

The takes are those that jobs.run makes: what can be rolled out together still is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import bpy

from ..blender.takes import baking
from ..blender.takes.baking import Plan, Result
from ..evaluation import metrics
from ..methods.take import Failure, Take, Tools
from ..pipeline.chain import MOST_AT_ONCE, networks
from ..pipeline.job import Job
from ..pipeline.refine_takes import refine_takes
from .saved_takes import KeptTakes

Made = tuple[list[Take], list[Failure]]


def run(
    context: bpy.types.Context,
    job: Job,
    tools: Tools | None = None,
    kept: KeptTakes | None = None,
    tell: Callable[[str], None] = lambda text: None,
) -> Result:
    """The whole job with a character of its own unless one is named. tell: is given a line for each finished take.

    Raises SampError if not one take can be made.
    """
    plan = baking.read(context, job, new_character=True)
    tools = tools or networks()
    takes, failures = [], []
    for made, failed in _pieces(plan, tools, kept):
        for take in made:
            takes.append(take)
            error = metrics.position_error(take.motion, take.goal)
            tell(f"take {len(takes)}/{job.variants}: seed {take.seed}, {error:.1f} cm from its goal")
        failures += failed
    return baking.write(context, plan, takes, failures)


def _pieces(plan: Plan, tools: Tools, kept: KeptTakes | None) -> Iterator[Made]:
    """Finished takes as they come, in the order of their seeds, and what failed."""
    job = plan.job
    for first in range(0, job.variants, MOST_AT_ONCE):
        some = replace(job, seed=job.seed + first, variants=min(MOST_AT_ONCE, job.variants - first))
        unrefined = replace(plan, job=some, surroundings=None)
        takes, failures = _remembered(
            kept, f"{some.seed}-{some.variants}", lambda plan=unrefined: baking.synthesise(plan, tools=tools)
        )
        if plan.surroundings is None:
            yield takes, failures
            continue
        yield [], failures
        for take in takes:
            yield _remembered(
                kept,
                f"{take.seed}-refined",
                lambda take=take: refine_takes([take], plan.surroundings, plan.body, tools),
            )


def _remembered(kept: KeptTakes | None, piece: str, work: Callable[[], Made]) -> Made:
    """What a piece of work makes, or has made in a run before. What failed is tried again by another run."""
    made = kept.load(piece) if kept else None
    if made is None:
        made = work()
        if kept and not made[1]:
            kept.save(piece, *made)
    return made
