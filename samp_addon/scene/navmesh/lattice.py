"""Points on triangles, dense enough that no cell of a grid is missed.

Instead of exact clipping, each triangle is covered by a lattice: rows parallel to its longest edge.
"""

from __future__ import annotations

import numpy as np

from .. import geometry


def sample_triangles(corners: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return points (M, 3) on triangles, at most ``spacing`` metres apart, and their triangles (M,).

    corners: (3, 3, F), see geometry.by_corner. Edges and corners are included. A triangle smaller than the spacing is
    represented by its centre: in a mesh of such triangles no location is farther from a point than two thirds of the
    spacing.
    """
    a, b, c = corners
    squared = np.empty((3, corners.shape[2]))
    for k in range(3):
        edge = corners[(k + 1) % 3] - corners[k]
        squared[k] = geometry.dot(edge, edge)
    longest = np.sqrt(np.maximum(np.maximum(squared[0], squared[1]), squared[2]))
    tiny = np.flatnonzero(longest < spacing)
    large = np.flatnonzero(longest >= spacing)
    centres = (a.take(tiny, 1) + b.take(tiny, 1) + c.take(tiny, 1)) / 3
    if len(large) == 0:
        return centres.T, tiny
    longer = corners.take(large, axis=2).transpose(2, 0, 1)
    points, index = _rows(longer, squared[:, large].argmax(axis=0), longest[large], spacing)
    return np.concatenate([points, centres], axis=1).T, np.concatenate([large[index], tiny])


def _rows(
    triangles: np.ndarray, base: np.ndarray, length: np.ndarray, spacing: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return points (3, M) and triangle indices (M,), in rows along each triangle's edge ``base`` (F,) of ``length``
    (F,)."""
    each = np.arange(len(triangles))
    a, b, c = (triangles[each, (base + k) % 3] for k in range(3))
    height = 2 * geometry.areas(triangles) / length
    steps = np.ceil(height / spacing).astype(np.int64)
    owner, row = _count_up(steps + 1)
    up = row / np.maximum(steps, 1)[owner]
    across = np.ceil(length[owner] * (1 - up) / spacing - 1e-9).astype(np.int64)
    line, place = _count_up(across + 1)
    along = np.repeat(1 - up, across + 1) * place / np.repeat(np.maximum(across, 1), across + 1)
    points = np.empty((3, len(line)))
    for axis in range(3):  # one array per coordinate, and what a row has in common only once
        origin = a[:, axis]
        for_row = origin[owner], (b[:, axis] - origin)[owner], up * (c[:, axis] - origin)[owner]
        start, edge, rise = (np.repeat(values, across + 1) for values in for_row)
        points[axis] = start + along * edge + rise
    return points, owner[line]


def _count_up(counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Enumerate groups: for counts (2, 3), owners 0 0 1 1 1 and positions 0 1 0 1 2."""
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)


def clip_to_box(triangles: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return triangles (F', 3, 3) that overlap the box from low to high (3,), subdivided where they cross it."""
    done, waiting = [], triangles
    while len(waiting):
        least, most = waiting.min(axis=1), waiting.max(axis=1)
        outside = (least > high).any(1) | (most < low).any(1)
        crossing = (least < low).any(1) | (most > high).any(1)
        cut = ~outside & crossing & ((most - least).max(1) > 1.0)
        done.append(waiting[~outside & ~cut])
        waiting = _quartered(waiting[cut])
    return np.concatenate([np.zeros((0, 3, 3)), *done])


def _quartered(triangles: np.ndarray) -> np.ndarray:
    a, b, c = np.moveaxis(triangles, 1, 0)
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([np.stack(part, axis=1) for part in parts])
