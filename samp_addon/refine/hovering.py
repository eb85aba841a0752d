"""Hovering: bodies that neither touch anything nor jump are lowered onto what is under them. Network frame, metres."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace

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
PATCHES = 64  # of the skin
SLACK = 0.02  # metres by which the distances of a field, interpolated between cells, may be wrong


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
    patches = _patches(body)
    skin = human.skin(body, motion.pose_slice(rows), patches.vertices)
    radius = patches.radii(skin)
    height, sinking = np.zeros(len(rows)), np.arange(len(rows))
    for _ in range(MAX_STEPS):
        nearest = _nearest(skin[sinking], radius[sinking], height[sinking], field, patches)
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


@dataclass(frozen=True)
class _Patches:
    """Parts of the skin, each around one of its vertices. vertices: (V,) of the body, patch by patch, the middle of a
    patch first. first: (P,) index of each middle. count: (P,)."""

    vertices: np.ndarray
    first: np.ndarray
    count: np.ndarray

    def radii(self, skin: np.ndarray) -> np.ndarray:
        """Return how far (T, P) each patch of the skin (T, V, 3) extends from its middle, metres."""
        away = skin - np.repeat(skin[:, self.first], self.count, axis=1)
        away = away[..., 0] ** 2 + away[..., 1] ** 2 + away[..., 2] ** 2
        return np.sqrt(np.maximum.reduceat(away, self.first, axis=1))


@functools.lru_cache(maxsize=4)
def _patches(body: Human) -> _Patches:
    """Divide the collision vertices among PATCHES of them that are far from each other."""
    points = body.vertices[body.collision]
    away, owner, middles = np.full(len(points), np.inf), np.zeros(len(points), int), []
    for number in range(min(PATCHES, len(points))):
        middles.append(int(away.argmax()))
        gap = np.linalg.norm(points - points[middles[-1]], axis=-1)
        owner[gap < away] = number
        away = np.minimum(away, gap)
    order = np.lexsort((away, owner))
    count = np.bincount(owner)
    return _Patches(body.collision[order], np.cumsum(count) - count, count)


def _nearest(
    skin: np.ndarray, radius: np.ndarray, height: np.ndarray, field: Field, patches: _Patches
) -> np.ndarray:
    """Return the distance (T,) of the nearest vertex of each skin (T, V, 3), lowered by heights (T,), to the scene.

    Only patches are looked at that can be nearer than the nearest middle: no distance changes faster than the place.
    radius: (T, P) of the patches, metres.
    """
    distances = lambda points, down: field.at(points - down[:, None] * [0.0, 1.0, 0.0])[0]
    middles = skin[:, patches.first]
    away = distances(middles.reshape(-1, 3), np.repeat(height, middles.shape[1])).reshape(radius.shape)
    near = away - radius - SLACK < away.min(1, keepdims=True)
    row, vertex = np.nonzero(np.repeat(near, patches.count, axis=1))
    return np.minimum.reduceat(
        distances(skin[row, vertex], height[row]), np.searchsorted(row, np.arange(len(skin)))
    )


def settle(motion: Motion, field: Field, body: Human, sigma: float = SMOOTHING_SECONDS) -> Motion:
    """Lower a hovering motion onto what is under it. sigma: seconds, of the Gaussian over the descent."""
    down = gaussian_filter1d(hover_height(motion, field, body), sigma * motion.fps, mode="nearest")
    return replace(motion, root=motion.root - down[:, None] * [0.0, 1.0, 0.0])
