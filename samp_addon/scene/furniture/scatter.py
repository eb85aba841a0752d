"""Tells scattered tiny things, such as blades of grass and leaves, from furniture: feet walk through them."""

from __future__ import annotations

import numpy as np

from .parts import WELD, labels

LARGEST_BLADE = 0.01
"""Square metres of surface of the largest part that counts as tiny."""

TALLEST = 0.6
"""Metres of the largest extent of a part that counts as tiny."""

FEWEST = 200
"""Tiny parts in one mesh from which on they are scattered."""

LOOSE = 0.8
"""Vertices for each triangle: closed surfaces have half a vertex, separate quads two."""


def scale_of(matrix: np.ndarray) -> float:
    """Return the mean scale of a matrix (4, 4)."""
    return float(np.cbrt(abs(np.linalg.det(matrix[:3, :3]))))


def is_tiny(points: np.ndarray, corners: np.ndarray, scale: float) -> bool:
    """Return whether every connected part of a mesh is tiny.

    points: (V, 3), corners: (F, 3) indices, scale: metres for each unit of the points.
    """
    return len(corners) > 0 and bool(_tiny_parts(points, corners, scale)[1].all())


def without_blades(points: np.ndarray, corners: np.ndarray, scale: float) -> np.ndarray:
    """Return the triangles (F', 3) of a mesh without its tiny parts, where there are at least FEWEST of them."""
    if len(corners) < FEWEST or len(points) < LOOSE * len(corners):
        return corners
    label, tiny = _tiny_parts(points, corners, scale)
    return corners[~tiny[label]] if tiny.sum() >= FEWEST else corners


def _tiny_parts(points: np.ndarray, corners: np.ndarray, scale: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the part (F,) of each triangle, and which parts (P,) are tiny."""
    # Files often hold the corners of each triangle apart; those at one place are one vertex.
    corner = _places(points, scale)[corners]
    label = labels(corner, len(points))
    count = int(label.max()) + 1
    triangles = points[corners].astype(np.float64) * scale
    cross = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    area = np.bincount(label, 0.5 * np.linalg.norm(cross, axis=1), count)
    low, high = np.full((2, count, 3), [[[np.inf]], [[-np.inf]]])
    np.minimum.at(low, label, triangles.min(axis=1))
    np.maximum.at(high, label, triangles.max(axis=1))
    return label, (area < LARGEST_BLADE) & ((high - low).max(axis=1) < TALLEST)


def _places(points: np.ndarray, scale: float) -> np.ndarray:
    """Return the place (V,) of each vertex (V, 3): a number that vertices within WELD metres mostly share."""
    whole = np.round(points.astype(np.float64) * (scale / WELD)).astype(np.int64)
    # A hash: one column is sorted far faster than rows of three.
    key = whole[:, 0] * 73856093 ^ whole[:, 1] * 19349663 ^ whole[:, 2] * 83492791
    return np.unique(key, return_inverse=True)[1]
