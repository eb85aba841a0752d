"""A body as balls inside its skin, for distances between bodies over many frames.

The balls are maximal: each touches the skin from inside at two places or more (shrinking-ball algorithm, Ma et al.
2012), and moves with the skin weights of the vertex that it was grown from. Network frame, metres.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ..motion import Motion
from . import human
from .human import Human

LARGEST = 0.2
"""Radius in metres at which balls begin to shrink."""

SMALLEST = 0.006
"""Least radius in metres; smaller ones are folds of the skin."""

TOLERANCE = 0.02
"""Metres of skin that may stand out of the balls."""

ROUNDS = 30

KEPT = 16
"""Bodies in the cache."""


@dataclass(frozen=True, eq=False)
class Balls:
    """centres: a body whose vertices are the balls' centres (S, 3). radii: (S,)."""

    centres: Human
    radii: np.ndarray

    def at(self, motion: Motion) -> np.ndarray:
        """Return the centres (T, S, 3) in each frame of a motion, single precision."""
        return human.skin(self.centres, motion)


@dataclass(frozen=True, eq=False)
class Track:
    """A body over time. centres: (T, S, 3) of its balls, radii: (S,), rate: frames per second."""

    centres: np.ndarray
    radii: np.ndarray
    rate: float

    def __len__(self) -> int:
        return len(self.centres)

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return centre (T, 3) and radius (T,) of a ball around all of the body in each frame."""
        middle = (self.centres.min(1) + self.centres.max(1)) / 2
        reach = np.linalg.norm(self.centres - middle[:, None], axis=-1) + self.radii
        return middle, reach.max(1)


def of_body(body: Human) -> Balls:
    """Return the balls of a body: together they cover its skin up to TOLERANCE and never reach out of it.

    Cached: the characters of a cast often have the same shape.
    """
    key = np.round(np.concatenate([body.vertices, body.joints]), 3).tobytes()
    if key not in _known:
        while len(_known) >= KEPT:
            _known.pop(next(iter(_known)))
        _known[key] = _of_body(body)
    return _known[key]


_known: dict[bytes, Balls] = {}


def _of_body(body: Human) -> Balls:
    seeds = body.collision
    skin = body.vertices[seeds]
    centres, radii = _maximal(body.vertices, skin, _normals(body)[seeds])
    usable = radii >= SMALLEST
    chosen = _cover(skin, centres, radii, usable)
    vertices = seeds[chosen]
    shrunk = replace(
        body,
        vertices=centres[chosen],
        weight_joints=body.weight_joints[vertices],
        weights=body.weights[vertices],
        shapes={},
        collision=np.arange(len(chosen)),
    )
    return Balls(shrunk, radii[chosen])


def _normals(body: Human) -> np.ndarray:
    """Return the outward unit normals (V, 3) of the skin in the rest pose."""
    corners, total = body.vertices, np.zeros_like(body.vertices)
    for a, b, c in ((0, 1, 2), (0, 2, 3)):
        face = body.faces[:, [a, b, c]]
        area = np.cross(corners[face[:, 1]] - corners[face[:, 0]], corners[face[:, 2]] - corners[face[:, 0]])
        for k in range(3):
            np.add.at(total, face[:, k], area)
    return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12)


def _maximal(vertices: np.ndarray, skin: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return centre (N, 3) and radius (N,) of the largest ball inside the vertices (V, 3) that touches each point of
    the skin (N, 3)."""
    tree, radii = cKDTree(vertices), np.full(len(skin), LARGEST)
    for _ in range(ROUNDS):
        centres = skin - normals * radii[:, None]
        away, nearest = tree.query(centres)
        offset = skin - vertices[nearest]
        squared = (offset**2).sum(1)
        touching = squared / np.maximum(2 * (normals * offset).sum(1), 1e-9)
        smaller = (away < radii - 1e-3) & (touching < radii) & (squared > 1e-8)
        if not smaller.any():
            break
        radii = np.where(smaller, touching, radii)
    return skin - normals * radii[:, None], radii


def _cover(skin: np.ndarray, centres: np.ndarray, radii: np.ndarray, usable: np.ndarray) -> np.ndarray:
    """Return the balls that cover most of the skin, the one that covers the most of what is left first."""
    away = np.linalg.norm(skin[:, None] - centres[None], axis=-1)
    covers = (away < radii + TOLERANCE) & usable
    left, chosen = np.ones(len(skin), dtype=bool), []
    while left.any():
        gain = covers[left].sum(0)
        best = int(gain.argmax())
        if gain[best] < 3:
            break
        chosen.append(best)
        left &= ~covers[:, best]
    return np.array(chosen, dtype=np.int64)
