"""Signed distances of a body to what it may touch: the scene with soft seats, and the floor. Network frame, metres."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from ..scene.distance import signed_distance

MIN_LEVEL = 0.7
"""Cosine between a surface's normal and the vertical below which the surface is too steep to stand on."""


class Ground(Protocol):
    """What feet stand on."""

    def support(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the heights (N,) of the ground near soles (N, 3), NaN where there is none, and its normals (N, 3)."""


class Field:
    """Signed distances of the scene. A soft surface counts as hit only where it is entered deeper than it yields."""

    def __init__(
        self, triangles: np.ndarray, give: np.ndarray, floor: float | None, free: np.ndarray
    ) -> None:
        """triangles: (F, 3, 3). give: (F,) metres by which they yield. floor: height below which all is solid, or
        None. free: (N, 3) points, most of them outside of all solids."""
        self.floor = floor
        self.parts = [
            (signed_distance.cached_field(triangles[give == depth], free, floor), float(depth))
            for depth in np.unique(give)
        ]

    def at(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the distances (N,) of points (N, 3), at most signed_distance.BAND, and their gradients (N, 3), which
        point out of the scene."""
        distance, slope = np.full(len(points), signed_distance.BAND), np.zeros((len(points), 3))
        for number, (part, give) in enumerate(self.parts):
            found, gradient = part.at(points)
            if number == 0 and give == 0:  # most scenes have no other part
                distance, slope = found, gradient
                continue
            nearer = found + give < distance
            distance[nearer], slope[nearer] = found[nearer] + give, gradient[nearer]
        if self.floor is not None:
            above = points[:, 1] - self.floor
            nearer = above < distance
            distance[nearer], slope[nearer] = above[nearer], [0.0, 1.0, 0.0]
        return distance, slope

    def support(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the heights (N,) of the ground near soles (N, 3), NaN where there is none, and its normals (N, 3)."""
        distance, slope = self.at(points)
        length = np.linalg.norm(slope, axis=-1)
        normal = slope / np.maximum(length, 1e-9)[:, None]
        ground = (distance < signed_distance.BAND) & (np.abs(normal[:, 1]) > MIN_LEVEL) & (length > 0.5)
        height = np.where(ground, points[:, 1] - distance * normal[:, 1], np.nan)
        return height, normal * np.sign(np.where(normal[:, 1] == 0, 1.0, normal[:, 1]))[:, None]
