"""Steps for bodies that glide. A network that has seen few turns on the spot moves both feet over the floor at once;
here they take turns. Network frame, metres.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import uniform_filter1d

from ...evaluation.feet import glides
from ...motion import Motion, velocities
from .foot import FEET
from .stances import Stance

STEP = 16
"""Frames at 30 fps from one footfall to the next of a body that turns on the spot."""
SWING = 10
"""Frames at 30 fps of the shortest swing beside a glide."""
TOUCHING = 2
"""Frames between two stances of a foot that are one."""
TOGETHER = 1
"""Frames at 30 fps before and after each footfall in which both feet stand."""


def stepping(motion: Motion, feet: Sequence[Sequence[Stance]]) -> list[list[Stance]]:
    """Return the stances of both feet, in the order of FEET, with alternate ones wherever the body glides.

    feet: stances by the labels. Those inside a glide are replaced, and others end where it begins.
    """
    found = [list(own) for own in feet]
    for first, last in glides(motion):
        for k, planned in enumerate(_alternate(motion, first, last)):
            kept = [piece for stance in found[k] for piece in _outside(stance, first, last)]
            inside = sorted(kept + planned, key=lambda stance: stance.first)
            found[k] = _apart(inside, round(SWING * motion.fps / 30))
    return found


def _alternate(motion: Motion, first: int, last: int) -> list[list[Stance]]:
    """Return the stances of both feet in a glide: the foot that is faster at its beginning makes the first step."""
    count = max(1, round((last - first) * 30 / motion.fps / STEP))
    bounds = np.linspace(first, last, count + 1).round().astype(int)
    both = round(TOGETHER * motion.fps / 30)
    speeds = _speeds(_balls(motion), motion.fps)[bounds[0] : bounds[1]].mean(0)
    out: list[list[Stance]] = [[], []]
    for k in range(count):
        stands = (int(speeds.argmin()) + k) % 2
        begins = max(int(bounds[k]) - both, 0)
        out[stands].append(Stance(begins, min(int(bounds[k + 1]) + both, len(motion))))
    return out


def _outside(stance: Stance, first: int, last: int) -> list[Stance]:
    """Return the parts of a stance before and after a glide."""
    parts = [(stance.first, min(stance.last, first)), (max(stance.first, last), stance.last)]
    return [Stance(a, b) for a, b in parts if b - a >= 3]


def _apart(stances: Sequence[Stance], swing: int) -> list[Stance]:
    """Return stances in order of time, with those that touch made one, since a foot cannot jump, and with at least
    ``swing`` frames between the others."""
    out: list[Stance] = []
    for stance in stances:
        gap = stance.first - out[-1].last if out else swing
        if gap <= TOUCHING:
            out[-1] = Stance(out[-1].first, max(stance.last, out[-1].last))
            continue
        missing = max(swing - gap, 0)
        if missing:
            out[-1] = Stance(out[-1].first, max(out[-1].last - missing // 2, out[-1].first + 1))
        begins = stance.first + missing - missing // 2
        if begins < stance.last:
            out.append(Stance(begins, stance.last))
    return out


def _balls(motion: Motion) -> np.ndarray:
    """Return the balls of both feet (T, 2, 3), in the order of FEET."""
    return motion.forward_kinematics()[0][:, [foot.ball for foot in FEET]]


def _speeds(balls: np.ndarray, fps: float) -> np.ndarray:
    """Return the horizontal speeds (T, 2) of the balls (T, 2, 3), m/s, averaged over five frames."""
    speed = np.linalg.norm(velocities(balls[..., [0, 2]], fps), axis=-1)
    return uniform_filter1d(speed, 5, axis=0, mode="nearest")
