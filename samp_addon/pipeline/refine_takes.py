"""Finished takes refined for the body that will show them. Without Blender, network frame, metres."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

from ..body import proportions
from ..body.human import Human
from ..errors import SampError
from ..methods.take import Failure, Take, Tools
from ..progress import Progress, SubProgress, show
from ..refine.refinement import Surroundings

STAGE = "Refining"


def refine_takes(
    takes: Sequence[Take],
    surroundings: Surroundings,
    body: Human,
    tools: Tools,
    progress: Progress = lambda stage, share: None,
) -> tuple[list[Take], list[Failure]]:
    """The takes, refined, and why others were not; those are still among the takes, as they were."""
    done, failures = [], []
    for count, take in enumerate(takes):
        part = SubProgress(progress, count / len(takes), 1 / len(takes), STAGE)
        part(STAGE, 0.0)
        show(progress, take.motion)
        try:
            done.append(_refined(take, surroundings, body, tools, part))
        except SampError as error:
            done.append(take)
            failures.append(Failure(take.seed, f"The take is not refined: {error}"))
    progress("Done", 1.0)
    return done, failures


def _refined(take: Take, surroundings: Surroundings, body: Human, tools: Tools, progress: Progress) -> Take:
    begun = time.perf_counter()
    # A ground that was assumed under a scene without a floor has no triangles; all other floors have.
    around = replace(surroundings, floor=take.laid_ground)
    # On other proportions than the networks' the body touches other things.
    motion = proportions.adapt(take.motion, body.joints)
    result = tools.refine(motion, around, take.goal, body, None, progress)
    seconds = take.seconds | {"refine": time.perf_counter() - begun}
    return replace(take, motion=result.motion, refined=result, seconds=seconds)
