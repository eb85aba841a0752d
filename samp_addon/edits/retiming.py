"""Parts of a take faster or slower, each for itself, without sliding feet. Network frame, metres."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..errors import UsageError
from ..motion import Motion, velocities
from ..refine.feet.foot_lock import lock_to_plans
from ..refine.feet.plan import plan_feet
from ..refine.proportions.footprints import Footprints

PHASES = ("walk", "settle", "hold")
"""Until the body begins to sit or lie down; until it rests; to the end. A take without a rest is all walk."""

SLOWEST, FASTEST = 0.25, 4.0
"""Limits of a factor on the speed."""

SETTLED_SPEED = 0.12
"""Metres per second of the pelvis below which a body that has sat down rests."""

EASE = 0.35
"""Seconds over which the speed changes at a boundary between phases."""


@dataclass(frozen=True)
class Retimed:
    """A retimed motion. frames: (N,) frame of the source, with fractions, that each of its frames shows."""

    motion: Motion
    frames: np.ndarray


def phase_starts(motion: Motion) -> dict[str, int]:
    """Return the first frame of each phase that a take has, in order."""
    starts = {"walk": 0}
    first = motion.interaction_start
    if first is None or first >= len(motion) - 1:
        return starts
    starts = {"walk": 0, "settle": first} if first > 0 else {"settle": 0}
    speed = np.linalg.norm(velocities(motion.root, motion.fps), axis=-1)
    moving = np.flatnonzero(speed[first:] > SETTLED_SPEED)
    rest = first + (int(moving[-1]) + 1 if len(moving) else 0)
    if rest < len(motion) - 1:
        starts["hold"] = rest
    return starts


def retimed(motion: Motion, factors: Mapping[str, float]) -> Retimed:
    """Play the phases of a take faster or slower.

    factors: speed of each phase relative to the take's; 1 where it is left out. The speed changes gradually between
    phases. Feet that stand are held where they stood. Raises UsageError for an unknown phase or a factor beyond the
    limits.
    """
    for name, factor in factors.items():
        if name not in PHASES:
            raise UsageError(f"There is no phase '{name}'; choose one of {', '.join(PHASES)}.")
        if not SLOWEST <= factor <= FASTEST:
            raise UsageError(f"The speed of '{name}' is {factor:g}; choose from {SLOWEST:g} to {FASTEST:g}.")
    frames = _source_frames(motion, factors)
    if len(frames) == len(motion) and np.abs(frames - np.arange(len(motion))).max() < 1e-9:
        return Retimed(motion, frames)
    warped = motion.at_frames(frames)
    # Faster stances slide faster; the ground is where the feet of the take stood.
    prints = Footprints.of(warped)
    return Retimed(lock_to_plans(warped, plan_feet(warped, prints), prints), frames)


def _source_frames(motion: Motion, factors: Mapping[str, float]) -> np.ndarray:
    """Return the source frames (N,), with fractions, that the frames of the retimed take show."""
    from scipy.ndimage import uniform_filter1d

    count = len(motion)
    speed = np.ones(count)
    starts = list(phase_starts(motion).items())
    for k, (name, first) in enumerate(starts):
        last = starts[k + 1][1] if k + 1 < len(starts) else count
        speed[first:last] = factors.get(name, 1.0)
    slowness = uniform_filter1d(1 / speed, max(int(round(EASE * motion.fps)), 1), mode="nearest")
    # When each source frame is shown, in frames of the result.
    shown = np.concatenate([[0.0], np.cumsum((slowness[1:] + slowness[:-1]) / 2)])
    total = max(int(round(shown[-1])) + 1, min(2, count))
    return np.interp(np.linspace(0, shown[-1], total), shown, np.arange(count))
