"""Hovering: bodies that neither touch anything nor jump are lowered onto what is under them. Network frame, metres."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ..body import human
from ..body.human import Human
from ..motion import Motion
from .field import Field
from .runs import runs

TOUCHING = 0.007  # metres within which skin counts as touching
MAX_HEIGHT = 0.30  # metres; higher bodies are meant to be there
RATE = 30.0  # samples of the height per second
SMOOTHING_SECONDS = 0.08  # standard deviation of the Gaussian over the descent
ACCELERATION_SECONDS = 0.06  # standard deviation of the Gaussian under the pelvis' acceleration
FALLING = -4.0  # m/s^2 of the pelvis below which a body is in flight; less than half of gravity is no flight
MAX_STEPS = 8  # of sphere tracing


def supported(motion: Motion) -> np.ndarray:
    """Return flags (T,) of the frames in which something supports the body: a freely falling pelvis is in flight."""
    if len(motion) < 4:
        return np.ones(len(motion), bool)
    acceleration = gaussian_filter1d(
        motion.root[:, 1], ACCELERATION_SECONDS * motion.fps, order=2, mode="nearest"
    )
    return acceleration * motion.fps**2 > FALLING


def hover_height(motion: Motion, field: Field, body: Human) -> np.ndarray:
    """Return how high (T,) the body hovers over what is under it; 0 where it touches something, jumps, or is far up.

    Sphere tracing: the body can sink by the distance of its nearest skin without hitting anything, then again.
    """
    rows = np.arange(0, len(motion), max(1, round(motion.fps / RATE)))
    skin = human.skin(body, motion.pose_slice(rows), body.collision).astype(np.float64)
    height, sinking = np.zeros(len(rows)), np.arange(len(rows))
    for _ in range(MAX_STEPS):
        points = skin[sinking] - height[sinking, None, None] * [0.0, 1.0, 0.0]
        nearest = field.at(points.reshape(-1, 3))[0].reshape(len(sinking), -1).min(1)
        height[sinking] += np.maximum(nearest - TOUCHING, 0.0)
        sinking = sinking[(nearest > TOUCHING + 1e-3) & (height[sinking] < MAX_HEIGHT)]
        if not len(sinking):
            break
    height = np.interp(np.arange(len(motion)), rows, height)
    held_up = supported(motion)
    for first, last in runs(height > 0, 1, 0):
        if held_up[first:last].mean() < 0.5 or height[first:last].max() >= MAX_HEIGHT:
            height[first:last] = 0.0
    return height


def settle(motion: Motion, field: Field, body: Human, sigma: float = SMOOTHING_SECONDS) -> Motion:
    """Lower a hovering motion onto what is under it. sigma: seconds, of the Gaussian over the descent."""
    down = gaussian_filter1d(hover_height(motion, field, body), sigma * motion.fps, mode="nearest")
    return replace(motion, root=motion.root - down[:, None] * [0.0, 1.0, 0.0])
