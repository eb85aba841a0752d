"""The two networks of SAMP as functions, so that tests and evaluations can put others in their place."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ... import dependencies
from ...errors import SampError
from ...motion import Goal, Motion
from .request import Request


@dataclass(frozen=True)
class Networks:
    """GoalNet and MotionNet.

    sample_goals: (triangles, action, count, seed, obstacles) and the height of the floor where the object does not
    stand on it -> goals, see goals.py. generate: (requests, progress) -> a Motion or an error for each request, see
    rollout/generator.py.
    """

    sample_goals: Callable[..., Sequence[Goal]]
    generate: Callable[[Sequence[Request], Callable[[float], None]], Sequence[Motion | SampError]]


def trained() -> Networks:
    """Return the trained networks. Imports torch."""
    dependencies.load_torch()
    from . import goals
    from .rollout import generator

    return Networks(goals.sample_goals, generator.generate)
