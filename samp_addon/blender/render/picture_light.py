"""Light of a traced picture: a lamp under the ceiling, light from all around, exposure by what is seen.

The same model as in training/rooms/pictures/shading.py, with one neutral lamp in place of random ones: the networks
have seen many kinds of light, so that the artist's own lamps do not have to be imitated.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

SKY = (0.8, 0.9, 1.0)
LAMP, AMBIENT = np.array([1.0, 0.95, 0.88]), 0.45
NUDGE = 2e-3  # metres by which rays begin off a surface
SOFT = 0.08  # metres, radius of the lamp
AROUND = 3  # rays of each pixel for the light from all around
CLOSE = 0.7  # metres; nearer surfaces take light away
SEED = 0  # the same picture every time


class Rays(Protocol):
    """What answers how far rays get."""

    def distances(self, origins: np.ndarray, ways: np.ndarray, farthest: np.ndarray) -> np.ndarray:
        """Return distances (N,) from origins (N, 3) along unit directions (N, 3), at most farthest (N,)."""


class Seen(Protocol):
    """Where the pixels' rays hit: face (N,) or -1, point and normal (N, 3)."""

    face: np.ndarray
    point: np.ndarray
    normal: np.ndarray


def lit(scene: Rays, hits: Seen, base: np.ndarray, eye: np.ndarray) -> np.ndarray:
    """Return colours (N, 3) uint8 of pixels with base colours (N, 3), linear. eye: place of the camera (3,)."""
    random = np.random.default_rng(SEED)
    value = np.array(base, dtype=np.float64)
    rows = np.flatnonzero(hits.face >= 0)
    start = hits.point[rows] + NUDGE * hits.normal[rows]
    lamp = _lamp(hits.point[rows], eye)
    away = lamp + random.normal(0, SOFT, start.shape) - start
    far = np.linalg.norm(away, axis=-1)
    way = away / np.maximum(far, 1e-6)[:, None]
    facing = np.maximum((hits.normal[rows] * way).sum(-1), 0)
    wanted = np.maximum(far - 0.05, 1e-3)
    free = np.ones(len(rows), bool)
    turned = facing > 0
    free[turned] = scene.distances(start[turned], way[turned], wanted[turned]) >= wanted[turned] - 1e-6
    direct = (facing * free / np.maximum(far, 0.4) ** 2)[:, None] * LAMP * 2.0
    value[rows] *= direct + AMBIENT * _around(scene, start, hits.normal[rows], random)[:, None]
    return _developed(value)


def _lamp(points: np.ndarray, eye: np.ndarray) -> np.ndarray:
    """Return a place (3,) under the ceiling, over the middle of what is seen."""
    middle = (np.median(points, axis=0) + eye) / 2
    top = np.quantile(points[:, 1], 0.99)
    return np.array([middle[0], max(min(top - 0.15, eye[1] + 1.5), eye[1] + 0.3), middle[2]])


def _around(scene: Rays, start: np.ndarray, normal: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Return how open the surroundings (N,) are, 0.15 to 1."""
    total = np.zeros(len(start))
    for _ in range(AROUND):
        way = random.normal(size=start.shape)
        way = normal + way / np.linalg.norm(way, axis=-1, keepdims=True)
        way /= np.maximum(np.linalg.norm(way, axis=-1, keepdims=True), 1e-6)
        reach = scene.distances(start, way, np.full(len(start), CLOSE))
        total += np.clip(reach / CLOSE, 0.15, 1.0)
    return total / AROUND


def _developed(value: np.ndarray) -> np.ndarray:
    """Return linear light (N, 3) as uint8: exposed by the picture's mean, a soft shoulder, gamma 2.2."""
    middle = np.exp(np.log(value.mean(-1) + 1e-4).mean())
    exposed = value * 0.2 / middle if middle > 2e-4 else value
    mapped = exposed / (1 + 0.35 * exposed)
    return np.round(np.clip(mapped, 0, 1) ** (1 / 2.2) * 255).astype(np.uint8)
