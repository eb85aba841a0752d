"""What the chain is told of a scene, and the takes and failures that it makes. Network frame, metres."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

from ..errors import SampError
from ..motion import Goal, Motion
from ..refine import refinement
from ..refine.refinement import Refined
from ..scene.geometry import SceneGeometry
from .samp.request import Request


@dataclass(frozen=True)
class Situation:
    """What the chain needs to know of the artist's scene; network frame.

    scene: all triangles, the target's too, the character's not. target: (F, 3, 3) or None. parts:
    the target's names in the scene. start: floor
    position (3,) and yaw, or None for a free place. destination: floor position (3,) and yaw or None, for
    walks. goals: places on the target that the artist has chosen; empty to let GoalNet choose. via: floor positions
    (3,) that the way passes in their order.
    """

    scene: SceneGeometry
    target: np.ndarray | None = None
    parts: Sequence[str] = ()
    start: tuple[np.ndarray, float] | None = None
    destination: tuple[np.ndarray, float | None] | None = None
    goals: Sequence[Goal] = ()
    via: Sequence[np.ndarray] = ()


@dataclass(frozen=True)
class Take:
    """One generated take. goal: for walks at the standing pelvis' height. waypoints: (N, 3), start first.

    steps: the takes that it was joined from, see sequence.py; empty for a single action. laid_ground: height of the
    floor that was assumed where the scene has none, or None. refined: what its refinement changed, see refinement.py.
    """

    seed: int
    motion: Motion
    goal: Goal
    waypoints: np.ndarray
    seconds: dict[str, float] = field(default_factory=dict)
    attempts: int = 1
    steps: tuple[Take, ...] = ()
    laid_ground: float | None = None
    refined: Refined | None = None


@dataclass(frozen=True)
class Failure:
    """A take that could not be made, and why."""

    seed: int
    message: str


@dataclass(frozen=True)
class Tools:
    """The networks' part and the optimiser's, which tests replace.

    sample_goals: (triangles, action, count, seed, obstacles) -> goals. refine: as refine/refining.py has it.
    """

    sample_goals: Callable[[np.ndarray, str, int, int, np.ndarray], Sequence[Goal]]
    generate: Callable[[Sequence[Request], Callable[[float], None]], Sequence[Motion | SampError]]
    refine: Callable[..., Refined] = refinement.refine


class Clock:
    """Seconds by stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Adds the time inside to the stage's."""
        begun = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - begun
