"""Evenly spread samples of a scene's surface inside a box, and two-sided faces made single. Network frame, metres.

The memory is bounded by what lies in the box: large triangles are divided, and only the parts in the box are sampled.
"""

from __future__ import annotations

import numpy as np

from ..geometry import areas, evenly_inside, in_box, spread_over_surface
from .orientation import HASH_FACTORS, WELD, orient_outward

SPACING = 0.015
"""Metres between samples."""

LONGEST_EDGE = 0.5
"""Metres. Longer triangles are divided before sampling."""

MOST_SAMPLES = 2_000_000
"""Upper limit of the samples in a box; beyond it they are farther apart."""

FEWEST_SAMPLES = 1000
"""Least number of samples of a whole surface; those of a small one are closer together."""


def without_twins(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return triangles (F', 3, 3) of which none coincides with an earlier one, and flags (F,) of those kept.

    Triangles of a scene with twins are oriented outwards; others are returned as they are.

    Two-sided faces are exported as two opposite triangles, which cancel each other's winding number.
    """
    if len(triangles) == 0:
        return triangles, np.ones(0, bool)
    corners = np.zeros(triangles.shape[:2], np.uint64)
    for k in range(3):  # by columns: large scenes have millions of triangles
        corners += np.round(triangles[..., k] / WELD).astype(np.int64).astype(np.uint64) * HASH_FACTORS[k]
    corners.sort(axis=1)
    key = (corners * HASH_FACTORS).sum(-1, dtype=np.uint64)
    order = np.argsort(key, kind="stable")
    first = np.r_[True, key[order][1:] != key[order][:-1]]
    keep = np.zeros(len(triangles), bool)
    keep[order[first]] = True
    # Which twin faced outwards is unknown.
    return (triangles if keep.all() else orient_outward(triangles[keep])), keep


def samples_in_box(
    triangles: np.ndarray, low: np.ndarray, high: np.ndarray, spacing: float = SPACING
) -> tuple[np.ndarray, np.ndarray]:
    """Return surface samples (N, 3) in the box from low (3,) to high (3,), and their triangles' indices (N,)."""
    parts, owners, _ = _divided(triangles, low, high)
    area = areas(parts)
    total = float(area.sum())
    if total < spacing**2 / 4:
        return np.zeros((0, 3)), np.zeros(0, int)
    count = int(np.clip(np.ceil(total / spacing**2), 1, MOST_SAMPLES))
    samples, index = spread_over_surface(parts, count, area)
    inside = ((samples >= low) & (samples <= high)).all(1)
    return samples[inside], owners[index[inside]]


class FixedSamples:
    """Samples of a surface at fixed places: the samples in a box do not depend on the boxes asked for before.

    Every triangle has a range of the surface's whole area, and its halves have the halves of that range; the samples
    are at equal steps of it. Only in boxes with more than MOST_SAMPLES samples are they farther apart.
    """

    def __init__(self, triangles: np.ndarray, spacing: float = SPACING) -> None:
        """triangles: (F, 3, 3). spacing: metres between samples; small surfaces have FEWEST_SAMPLES."""
        self._triangles = triangles
        self._area = areas(triangles)
        self._before = np.cumsum(self._area) - self._area
        self._step = min(spacing**2, float(self._area.sum()) / FEWEST_SAMPLES)

    def within(self, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the samples (N, 3) in the box from low (3,) to high (3,), and their triangles' indices (N,)."""
        parts, owners, ranges = _divided(self._triangles, low, high)
        if self._step <= 0 or not len(parts):
            return np.zeros((0, 3)), np.zeros(0, int)
        ends = (self._before[owners] + ranges * self._area[owners]) / self._step
        first, last = np.ceil(ends - 0.5).astype(np.int64)
        every = max(1, int(np.ceil((last - first).sum() / MOST_SAMPLES)))
        first, last = -(-first // every), -(-last // every)
        count = last - first
        index = np.repeat(np.arange(len(parts)), count)
        step = np.arange(len(index)) + np.repeat(first - np.cumsum(count) + count, count)
        samples = evenly_inside(parts, index, every * step)
        inside = in_box(samples, low, high)
        return samples[inside], owners[index[inside]]


def _divided(
    triangles: np.ndarray, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the parts, with short edges, of the triangles that overlap a box, from low (3,) to high (3,).

    Returns the parts (N, 3, 3), the indices (N,) of their triangles, and the ranges (2, N) of the triangle's area that
    they take, from 0 to 1.
    """
    owners = np.flatnonzero(_overlap(triangles, low, high))
    parts, ranges = triangles[owners].astype(np.float64), np.repeat([[0.0], [1.0]], len(owners), 1)
    done = []
    while len(parts):
        edges = np.roll(parts, -1, axis=1) - parts
        long = np.square(edges).sum(-1).max(1) > LONGEST_EDGE**2
        # Small and overlapping: kept whole, the samples outside of the box are dropped later.
        done.append((parts[~long], owners[~long], ranges[:, ~long]))
        parts, owners, (begin, end) = parts[long], owners[long], ranges[:, long]
        if not len(parts):
            break
        parts, owners, middle = _halves(parts, edges[long]), np.tile(owners, 2), (begin + end) / 2
        ranges = np.stack([np.r_[begin, middle], np.r_[middle, end]])
        near = _overlap(parts, low, high)
        parts, owners, ranges = parts[near], owners[near], ranges[:, near]
    if not done:
        return np.zeros((0, 3, 3)), np.zeros(0, int), np.zeros((2, 0))
    return tuple(np.concatenate(of, axis=-1 if of[0].ndim == 2 else 0) for of in zip(*done, strict=True))


def _halves(triangles: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Divide each triangle (N, 3, 3) at the middle of its longest edge; return the halves (2 N, 3, 3)."""
    first = np.square(edges).sum(-1).argmax(1)
    rows = np.arange(len(triangles))
    a, b, c = (triangles[rows, (first + k) % 3] for k in range(3))
    middle = (a + b) / 2
    return np.concatenate([np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)])


def _overlap(triangles: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Flag the triangles (F,) of (F, 3, 3) whose bounding boxes overlap a box."""
    flags = np.ones(len(triangles), bool)
    for k in range(3):  # by columns: numpy reduces a short last axis slowly
        x = triangles[:, 0, k], triangles[:, 1, k], triangles[:, 2, k]
        flags &= np.maximum(np.maximum(*x[:2]), x[2]) >= low[k]
        flags &= np.minimum(np.minimum(*x[:2]), x[2]) <= high[k]
    return flags
