"""Weight: who hovers over things without jumping comes down on them. Network frame, metres."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ..body import human
from ..body.human import Human
from ..motion import Motion
from .field import Field
from .foot_lock import spells

TOUCHING = 0.007  # metres within which skin counts as touching
MOST = 0.30  # metres; who is higher is meant to be there
A_SECOND = 30.0  # times that the height is looked at
EVEN_SECONDS = 0.08  # standard deviation over which the way down is smoothed
PULL_SECONDS = 0.06  # standard deviation over which the pelvis' acceleration is taken
FALLING = -4.0  # m/s^2 of the pelvis; less than half of gravity's pull is no flight
LOOKS = 8


def carried(motion: Motion) -> np.ndarray:
    """Flags (T,) of the frames in which something holds the character up: a pelvis that falls freely is in flight."""
    if len(motion) < 4:
        return np.ones(len(motion), bool)
    pull = gaussian_filter1d(motion.root[:, 1], PULL_SECONDS * motion.fps, order=2, mode="nearest")
    return pull * motion.fps**2 > FALLING


def hover(motion: Motion, field: Field, body: Human) -> np.ndarray:
    """Metres (T,) that the body hovers over what is under it; 0 where it touches something, jumps, or is far up.

    Sphere tracing: down by the distance of the nearest skin nothing can be met, so that is how far one goes.
    """
    rows = np.arange(0, len(motion), max(1, round(motion.fps / A_SECOND)))
    skin = human.skin(body, motion.pose_slice(rows), body.collision).astype(np.float64)
    height, falling = np.zeros(len(rows)), np.arange(len(rows))
    for _ in range(LOOKS):
        points = skin[falling] - height[falling, None, None] * [0.0, 1.0, 0.0]
        nearest = field.at(points.reshape(-1, 3))[0].reshape(len(falling), -1).min(1)
        height[falling] += np.maximum(nearest - TOUCHING, 0.0)
        falling = falling[(nearest > TOUCHING + 1e-3) & (height[falling] < MOST)]
        if not len(falling):
            break
    height = np.interp(np.arange(len(motion)), rows, height)
    held = carried(motion)
    for first, last in spells(height > 0, 1, 0):
        if held[first:last].mean() < 0.5 or height[first:last].max() >= MOST:
            height[first:last] = 0.0
    return height


def settled(motion: Motion, field: Field, body: Human, even: float = EVEN_SECONDS) -> Motion:
    """The motion without its hovering. even: standard deviation, seconds, over which the way down is smoothed."""
    down = gaussian_filter1d(hover(motion, field, body), even * motion.fps, mode="nearest")
    return replace(motion, root=motion.root - down[:, None] * [0.0, 1.0, 0.0])
