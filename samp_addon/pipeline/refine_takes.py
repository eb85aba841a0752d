"""A finished take refined for the body that will show it. Without Blender; network frame, metres."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from ..body import proportions
from ..body.human import Human
from ..errors import SampError
from ..methods.take import Failure, Take
from ..motion import Motion
from ..progress import Progress, SubProgress, show
from ..refine.refinement import Refined, Surroundings

STAGE = "Refining"

WORSE = 0.02
"""Metres by which a refined body may be deeper in the scene than it was."""

Refine = Callable[..., Refined]
"""As refine.refinement.refine."""


def refine_take(
    take: Take, surroundings: Surroundings, body: Human, refine: Refine, progress: Progress
) -> tuple[Take, Failure | None]:
    """Return the take refined, or as it was with the reason why it is not. Raise what the progress callback raises."""
    part = SubProgress(progress, stage=STAGE)
    part(STAGE, 0.0)
    show(progress, take.motion)
    begun = time.perf_counter()
    # A ground that was assumed under a scene without a floor has no triangles; all other floors have.
    around = replace(surroundings, floor=take.laid_ground)
    try:
        motion = proportions.adapt(take.motion, body.joints)
        result = _no_worse(motion, refine(motion, around, take.goal, body, None, part))
    except SampError as error:
        return take, Failure(take.seed, f"The take is not refined: {error}")
    seconds = take.seconds | {"refine": time.perf_counter() - begun}
    return replace(take, motion=result.motion, refined=result, seconds=seconds), None


def _no_worse(motion: Motion, result: Refined) -> Refined:
    """Return the result of refining a motion; the motion itself where it was better.

    It is better where only it reaches the goal, or where the result is deeper in the scene by more than WORSE.
    """
    deepest = result.before.get("penetration_max_cm", 0.0) / 100
    lost = result.before.get("success", False) and not result.after.get("success", False)
    if not lost and result.unsolved <= deepest + WORSE:
        return result
    what = "moved the take off its goal" if lost else "pushed the body deeper into the scene"
    note = f"The take is as before refining, which would have {what}; move the furniture or the character."
    return replace(result, motion=motion, after=result.before, unsolved=deepest, notes=(note,))
