"""Takes of several characters at the same time, and how deep their bodies are in each other. Network frame, metres."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ...body import balls, proportions
from ...body.balls import Track
from ...body.human import Human
from ...evaluation.between_bodies import over_time
from ...methods.take import Failure, Take
from ...motion import Motion

OVERLAP = 0.02
"""Metres that two bodies may be in each other."""


@dataclass(frozen=True)
class CastTake:
    """Takes of a cast that begin in the same frame.

    takes: by the members' numbers. targets: the piece of furniture that each takes. waits: seconds that each waits
    before it sets off. failures: members without a take, and why. deepest: metres that a body is in another one at
    most. overlapping: share of the frames in which two bodies are more than OVERLAP in each other.
    """

    seed: int
    takes: Mapping[int, Take]
    targets: Mapping[int, str] = field(default_factory=dict)
    waits: Mapping[int, float] = field(default_factory=dict)
    failures: Mapping[int, str] = field(default_factory=dict)
    deepest: float = 0.0
    overlapping: float = 0.0


def track(motion: Motion, body: Human, rate: float) -> Track:
    """Return a motion's body as balls over time."""
    own = balls.of_body(body)
    shown = proportions.adapt(motion, body.joints).resampled(rate)
    return Track(own.at(shown), own.radii, rate)


def overlaps(motions: Mapping[int, Motion], bodies: Mapping[int, Human]) -> dict[tuple[int, int], np.ndarray]:
    """Return how deep each two bodies are in each other in each frame (T,), metres, see over_time."""
    tracks = {k: track(motion, bodies[k], motion.fps) for k, motion in motions.items()}
    numbers = sorted(tracks)
    return {(a, b): over_time(tracks[a], tracks[b]) for i, a in enumerate(numbers) for b in numbers[i + 1 :]}


def failures(take: CastTake) -> list[Failure]:
    """Return the members without a take."""
    return [Failure(take.seed, message) for message in take.failures.values()]
