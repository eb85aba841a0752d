"""Takes of one step, repeated where they fail or contain physically impossible motion: which attempt is kept."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from ..clock import Clock
from ..errors import SampError
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


@dataclass(frozen=True)
class Part:
    """Takes of one step in one scene, among others that are generated with them."""

    method: Method
    step: Step
    scene: SceneView
    seeds: Sequence[int]


Made = tuple[list[Take], list[Failure]]


def generate(method: Method, step: Step, scene: SceneView, seeds: Sequence[int], progress: Progress) -> Made:
    """Return the best take of each seed, and why the other seeds have none. Raise what the progress callback raises.

    Takes are generated in batches of the method's size; those that failed are tried again together.
    """
    return generate_together([Part(method, step, scene, seeds)], progress)[0]


def generate_together(parts: Sequence[Part], progress: Progress) -> list[Made]:
    """Do `generate` for several parts; those of a method that can make them in one batch are made so."""
    best: dict[tuple[int, int], Take] = {}
    ranks: dict[tuple[int, int], Rank] = {}
    obstacles = [shared(part.scene.geometry.triangles) for part in parts]
    reasons: dict[tuple[int, int], str] = {}
    clock = Clock()
    waiting = [(number, seed) for number, part in enumerate(parts) for seed in part.seeds]
    for attempt in range(ATTEMPTS):
        for batch in _batches(parts, waiting):
            made = _attempt(parts, batch, attempt, progress)
            clock.add(next((takes[0].seconds for takes, _ in made.values() if takes), {}))
            for number, (takes, failures) in made.items():
                for failure in failures:
                    reasons.setdefault((number, failure.seed), failure.message)
                for take in takes:
                    rank, key = rank_of(take, obstacles[number]), (number, take.seed)
                    if key not in best or rank < ranks[key]:
                        best[key], ranks[key] = replace(take, attempts=attempt + 1), rank
        waiting = [key for key in waiting if key not in best or ranks[key][:2] > (False, 0)]
        if not waiting:
            break
    progress("Done", 1.0)
    found = []
    for number, part in enumerate(parts):
        keys = [(number, seed) for seed in part.seeds]
        kept = [replace(best[key], seconds=dict(clock.seconds)) for key in keys if key in best]
        found.append((kept, [Failure(key[1], reasons[key]) for key in keys if key not in best]))
    return found


def _batches(
    parts: Sequence[Part], waiting: Sequence[tuple[int, int]]
) -> Iterator[Sequence[tuple[int, int]]]:
    """Yield the takes, as (part, seed), that are generated in one call of a method."""
    for method in dict.fromkeys(part.method for part in parts):
        own = [key for key in waiting if parts[key[0]].method is method]
        if not hasattr(method, "generate_together"):
            groups = [[key for key in own if key[0] == number] for number in dict.fromkeys(k for k, _ in own)]
        else:
            groups = [own]
        for group in groups:
            for begin in range(0, len(group), method.batch_size):
                yield group[begin : begin + method.batch_size]


def _attempt(
    parts: Sequence[Part], batch: Sequence[tuple[int, int]], attempt: int, progress: Progress
) -> dict[int, Made]:
    """Return what one call of a method makes, by the parts' numbers."""
    numbers = list(dict.fromkeys(number for number, _ in batch))
    draws = {
        number: [Draw(seed, (seed + attempt * NEXT_ATTEMPT) % 2**31) for k, seed in batch if k == number]
        for number in numbers
    }
    method = parts[numbers[0]].method
    if len(numbers) == 1:
        part, own = parts[numbers[0]], draws[numbers[0]]
        try:
            return {numbers[0]: method.generate(part.step, part.scene, own, progress)}
        except SampError as error:
            if len(parts) == 1:
                raise
            return {numbers[0]: ([], [Failure(draw.seed, str(error)) for draw in own])}
    jobs = [(parts[number].step, parts[number].scene, draws[number]) for number in numbers]
    return dict(zip(numbers, method.generate_together(jobs, progress), strict=True))


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
