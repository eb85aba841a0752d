"""Takes of one step, repeated where they fail or contain physically impossible motion: which attempt is kept."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..clock import Clock
from ..evaluation import guards, metrics, support
from ..evaluation.obstacles import Obstacles, shared
from ..methods.method import Draw, Method
from ..methods.scene_view import SceneView
from ..methods.step import Step
from ..methods.take import Failure, Take
from ..motion import Motion
from ..progress import Progress
from ..vocabulary import SEATED

ATTEMPTS = 3
"""A take that fails, ends off its goal or breaks a guarded measure is tried again with other noise, which also draws
another place."""

MOST_STOOP = 0.09
"""Metres that the pelvis may end lower than in standing on straight legs: some captured people stoop at the end."""

NEXT_ATTEMPT = 1_000_003
"""Added to the seed for the noise of another attempt: far from the seeds that an artist counts through."""

LOOKED_AT = 3
"""Frames from one to the next that is judged; the report measures all."""

Rank = tuple[bool, int, float]
"""As of rank_of."""


def generate(
    method: Method, step: Step, scene: SceneView, seeds: Sequence[int], progress: Progress
) -> tuple[list[Take], list[Failure]]:
    """Return the best take of each seed, and why the other seeds have none. Raise what the progress callback raises.

    Takes are generated in batches of the method's size; those that failed are tried again together.
    """
    best: dict[int, Take] = {}
    ranks: dict[int, Rank] = {}
    obstacles = shared(scene.geometry.triangles)
    reasons: dict[int, str] = {}
    clock, waiting = Clock(), list(seeds)
    for number in range(ATTEMPTS):
        for begin in range(0, len(waiting), method.batch_size):
            batch = waiting[begin : begin + method.batch_size]
            draws = [Draw(seed, (seed + number * NEXT_ATTEMPT) % 2**31) for seed in batch]
            takes, failures = method.generate(step, scene, draws, progress)
            clock.add(takes[0].seconds if takes else {})
            for failure in failures:
                reasons.setdefault(failure.seed, failure.message)
            for take in takes:
                rank = rank_of(take, obstacles)
                if take.seed not in best or rank < ranks[take.seed]:
                    best[take.seed], ranks[take.seed] = replace(take, attempts=number + 1), rank
        waiting = [seed for seed in waiting if seed not in best or ranks[seed][:2] > (False, 0)]
        if not waiting:
            break
    progress("Done", 1.0)
    kept = [replace(best[seed], seconds=dict(clock.seconds)) for seed in seeds if seed in best]
    return kept, [Failure(seed, reasons[seed]) for seed in seeds if seed not in best]


def rank_of(take: Take, obstacles: Obstacles) -> Rank:
    """Return how good a take is, the best one first: whether it missed its goal, the number of guarded measures that
    it breaks, and how far it ends from its goal, centimetres."""
    numbers = support.measures(_thinned(take.motion), take.goal, obstacles, take.floor)
    return not arrived(take), len(guards.broken(numbers)), error(take)


def _thinned(motion: Motion) -> Motion:
    """Return every LOOKED_AT-th frame of a motion."""
    rows = slice(None, None, LOOKED_AT)
    actions = None if motion.actions is None else motion.actions[rows]
    return replace(motion.pose_slice(rows), fps=motion.fps / LOOKED_AT, actions=actions)


def error(take: Take) -> float:
    """Return how far the take ends from its goal, centimetres; 0 for a take without one."""
    return 0.0 if take.goal is None else metrics.position_error(take.motion, take.goal)


def arrived(take: Take) -> bool:
    """Whether a take ends on its goal, and upright if it was a walk. A take without a goal always does."""
    goal = take.goal
    if goal is None:
        return True
    stooping = goal.action not in SEATED and take.motion.root[-1, 1] < goal.position[1] - MOST_STOOP
    return metrics.success(take.motion, goal) and not stooping
