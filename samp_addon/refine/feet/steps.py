"""Alternate stances for bodies that glide. Network frame, metres.

A network that was trained with few turns on the spot moves both feet over the floor at once. The stances planned here
make one foot stand while the other one swings.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...evaluation.feet import glides, smoothed_speeds
from ...motion import Motion
from .foot import FEET
from .stances import Stance

STEP = 16
"""Frames at 30 fps from one footfall to the next of a body that turns on the spot."""
SWING = 10
"""Frames at 30 fps of the shortest swing beside a glide."""
TOUCHING = 2
"""Frames between two stances of a foot up to which they become one."""
TOGETHER = 1
"""Frames at 30 fps before and after each footfall in which both feet stand."""
SHORTEST = 3
"""Frames of the shortest part of a stance that is kept beside a glide."""


def stepping(motion: Motion, feet: Sequence[Sequence[Stance]]) -> list[list[Stance]]:
    """Return the stances of both feet, in the order of FEET, with alternate ones wherever the body glides.

    feet: stances by the labels. Their parts inside a glide are replaced; those before and after it are kept.
    """
    found = [list(own) for own in feet]
    gliding = glides(motion)
    if not gliding:
        return found
    balls = motion.forward_kinematics()[0][:, [foot.ball for foot in FEET]]
    speeds = smoothed_speeds(balls[..., [0, 2]], motion.fps)
    for first, last in gliding:
        for k, planned in enumerate(_alternate(speeds, motion.fps, first, last)):
            kept = [piece for stance in found[k] for piece in _outside(stance, first, last)]
            inside = sorted(kept + planned, key=lambda stance: stance.first)
            found[k] = _apart(inside, round(SWING * motion.fps / 30))
    return found


def _alternate(speeds: np.ndarray, fps: float, first: int, last: int) -> list[list[Stance]]:
    """Return the stances of both feet, in the order of FEET, in a glide from frame ``first`` up to ``last``.

    The foot that is faster at the beginning makes the first step. speeds: (T, 2) of the balls of the feet, m/s.
    """
    count = max(1, round((last - first) * 30 / fps / STEP))
    bounds = np.linspace(first, last, count + 1).round().astype(int)
    both = round(TOGETHER * fps / 30)
    begin = speeds[bounds[0] : bounds[1]].mean(0)
    out: list[list[Stance]] = [[], []]
    for k in range(count):
        stands = (int(begin.argmin()) + k) % 2
        begins = max(int(bounds[k]) - both, 0)
        out[stands].append(Stance(begins, min(int(bounds[k + 1]) + both, len(speeds))))
    return out


def _outside(stance: Stance, first: int, last: int) -> list[Stance]:
    """Return the parts of a stance before and after a glide."""
    parts = [(stance.first, min(stance.last, first)), (max(stance.first, last), stance.last)]
    return [Stance(a, b) for a, b in parts if b - a >= SHORTEST]


def _apart(stances: Sequence[Stance], swing: int) -> list[Stance]:
    """Return stances in order of time with at least ``swing`` frames between them.

    Stances at most TOUCHING frames apart become one, since a foot cannot jump.
    """
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
