"""Where a take may be: upright on walkable ground, low only over something that carries the body."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ...scene import geometry
from ...scene.distance.signed_distance import BAND, SignedDistance, around_ground
from ...scene.navmesh.navmesh import NavMesh

OFF = 0.15
"""Metres beside the navmesh that still count as on it."""
UPRIGHT = 0.75
"""Height of the pelvis over the floor, of standing, from which on a body is upright."""
REACH, UNDER = 1.2, (0.02, 0.32)
"""A seated pelvis is at most so far from walkable ground, and a surface is this far under it; metres."""
SAMPLES = 60_000


@dataclass(frozen=True)
class Ground:
    """The navmesh and the surfaces of a scene. triangles: (F, 3, 3). standing: height of the pelvis, metres."""

    mesh: NavMesh
    triangles: np.ndarray
    standing: float

    def floor(self, points: np.ndarray) -> np.ndarray:
        """Return the height (N,) of the walkable ground nearest to points (N, 3), height counted double."""
        weights = np.array([1.0, 2.0, 1.0])
        _, rows = self._walkable.query(points * weights)
        return self.mesh.points[rows, 1]

    def fits(self, root: np.ndarray, floor: float) -> np.ndarray:
        """Return in which frames (T,) a pelvis (T, 3) is at a place that a body can occupy.

        floor: height of the ground at the beginning.
        """
        below = root - [0.0, self.standing, 0.0]
        beside, _ = self._flat.query(root[:, [0, 2]])
        height = root[:, 1] - np.where(beside < REACH, self.floor(below), floor)
        upright = height > UPRIGHT * self.standing
        return np.where(upright, beside <= OFF, (beside <= REACH) & self.carried(root))

    def carried(self, root: np.ndarray) -> np.ndarray:
        """Return whether something is under each pelvis (T, 3) that it may sit on."""
        near = self._surface.query_ball_point(root - [0.0, sum(UNDER) / 2, 0.0], (UNDER[1] - UNDER[0]) / 2)
        return np.array([len(rows) > 0 for rows in near], bool)

    def upright(self, root: np.ndarray) -> np.ndarray:
        """Return in which frames a pelvis (T, 3) is as high as of a standing body."""
        return root[:, 1] - self.floor(root - [0.0, self.standing, 0.0]) > UPRIGHT * self.standing

    def depth(self, centres: np.ndarray, radii: np.ndarray) -> np.ndarray:
        """Return how deep the deepest of balls (T, S, 3) with radii (S,) is in the scene in each frame (T,), metres."""
        distance = self._field.at(centres.reshape(-1, 3))[0].reshape(centres.shape[:2])
        return np.maximum(np.minimum(radii, BAND) - distance, 0.0).max(1)

    @cached_property
    def _field(self) -> SignedDistance:
        return around_ground(self.triangles, self.mesh)

    @cached_property
    def _walkable(self) -> cKDTree:
        return cKDTree(self.mesh.points * [1.0, 2.0, 1.0])

    @cached_property
    def _flat(self) -> cKDTree:
        return cKDTree(self.mesh.points[:, [0, 2]])

    @cached_property
    def _surface(self) -> cKDTree:
        """Samples of the surfaces that face upwards."""
        points, face = geometry.sample_surface(self.triangles, SAMPLES, seed=0)
        corners = self.triangles[face]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        level = np.abs(normal[:, 1]) > 0.7 * np.linalg.norm(normal, axis=-1)
        return cKDTree(points[level])
