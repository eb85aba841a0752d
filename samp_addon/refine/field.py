"""How far a body is from what it may touch: the scene with soft seats, and the floor. Network frame, metres."""

from __future__ import annotations

import numpy as np

from ..scene.distance import signed_distance

STEEP = 0.7
"""Cosine between a surface and the floor from which on nobody stands on it."""


class Field:
    """Signed distances of the scene. What gives is entered by so much before it counts."""

    def __init__(
        self, triangles: np.ndarray, give: np.ndarray, floor: float | None, free: np.ndarray
    ) -> None:
        """triangles: (F, 3, 3). give: (F,) metres. floor: height under which all is solid, or None. free: (N, 3)
        places most of which are outside of all solids."""
        self.floor = floor
        self.parts = [
            (signed_distance.cached_field(triangles[give == depth], free, floor), float(depth))
            for depth in np.unique(give)
        ]

    def at(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances (N,) of points (N, 3), at most signed_distance.BAND and more, and the ways out (N, 3)."""
        distance, slope = np.full(len(points), signed_distance.BAND), np.zeros((len(points), 3))
        for part, give in self.parts:
            found, way = part.at(points)
            nearer = found + give < distance
            distance[nearer], slope[nearer] = found[nearer] + give, way[nearer]
        if self.floor is not None:
            above = points[:, 1] - self.floor
            nearer = above < distance
            distance[nearer], slope[nearer] = above[nearer], [0.0, 1.0, 0.0]
        return distance, slope

    def support(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Heights (N,) of the ground nearest to soles (N, 3), NaN where there is none near, and its normals (N, 3)."""
        distance, slope = self.at(points)
        length = np.linalg.norm(slope, axis=-1)
        way = slope / np.maximum(length, 1e-9)[:, None]
        ground = (distance < signed_distance.BAND) & (np.abs(way[:, 1]) > STEEP) & (length > 0.5)
        height = np.where(ground, points[:, 1] - distance * way[:, 1], np.nan)
        return height, way * np.sign(np.where(way[:, 1] == 0, 1.0, way[:, 1]))[:, None]
