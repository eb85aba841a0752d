"""Points on triangles, close enough together that no cell of a grid is missed.

A lattice on each triangle takes the place of exact clipping: rows along the longest edge, ``spacing`` apart.
"""

from __future__ import annotations

import numpy as np

from .. import geometry


def sample_triangles(triangles: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Points (M, 3) on triangles (F, 3, 3) with gaps of at most ``spacing`` metres, and their triangles (M,).

    Edges and corners are included. A triangle smaller than the spacing gives its centre only: among its like
    no place is farther from a point than two thirds of the spacing.
    """
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    squared = np.stack([np.einsum("fi,fi->f", edge, edge) for edge in (b - a, c - b, a - c)])
    longest = np.sqrt(np.maximum(np.maximum(squared[0], squared[1]), squared[2]))
    tiny = np.flatnonzero(longest < spacing)
    large = np.flatnonzero(longest >= spacing)
    centres = (a[tiny] + b[tiny] + c[tiny]) / 3
    if len(large) == 0:
        return centres, tiny
    points, index = _rows(triangles[large], squared[:, large].argmax(axis=0), longest[large], spacing)
    return np.concatenate([points, centres]), np.concatenate([large[index], tiny])


def _rows(
    triangles: np.ndarray, base: np.ndarray, length: np.ndarray, spacing: float
) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangle indices, in rows along each triangle's edge ``base`` (F,) of ``length`` (F,)."""
    each = np.arange(len(triangles))
    a, b, c = (triangles[each, (base + k) % 3] for k in range(3))
    height = 2 * geometry.areas(triangles) / length
    steps = np.ceil(height / spacing).astype(np.int64)
    owner, row = _count_up(steps + 1)
    up = row / np.maximum(steps, 1)[owner]
    across = np.ceil(length[owner] * (1 - up) / spacing - 1e-9).astype(np.int64)
    line, place = _count_up(across + 1)
    owner, up = owner[line], up[line]
    along = (1 - up) * place / np.maximum(across, 1)[line]
    # Column by column: three thin products instead of gathers of whole corners.
    points = np.empty((len(owner), 3))
    for axis in range(3):
        origin = a[:, axis]
        points[:, axis] = (
            origin[owner] + along * (b[:, axis] - origin)[owner] + up * (c[:, axis] - origin)[owner]
        )
    return points, owner


def _count_up(counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For counts (2, 3): owners 0 0 1 1 1 and places 0 1 0 1 2."""
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)


def clip_to_box(triangles: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The triangles (F', 3, 3) that meet the box from low to high (3,); those that stick out are cut up."""
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
