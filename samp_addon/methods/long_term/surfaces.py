"""The scene as the networks and the choice of bodies see it: points on its surfaces, and signed distances.

Network frame, metres.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ...scene.distance import solids
from ...scene.distance.signed_distance import SignedDistance, around_ground
from ...scene.geometry import sample_surface
from ...scene.navmesh.lattice import clip_to_box
from ...scene.navmesh.navmesh import NavMesh

MOST_POINTS = 512
"""Points of one cloud."""
TALL = 2.2
"""Metres over the floor over which nothing is seen."""
EVEN = 0.03
"""Metres by which the floor at two places may differ without a step between them."""
STEPPED = 1.0
"""Frames, sigma of the Gaussian over which the floor rises at a step."""


@dataclass(frozen=True)
class Surfaces:
    """The scene as the networks see it. triangles: (F, 3, 3). mesh: walkable ground."""

    triangles: np.ndarray
    mesh: NavMesh

    def cloud(self, places: np.ndarray, radius: float, level: float, seed: int) -> np.ndarray:
        """Return points (512, 3) of surfaces within a radius of any of some places (K, 3), seen from above."""
        low, high = places.min(0) - radius, places.max(0) + radius
        low[1], high[1] = level - 0.1, level + TALL
        near = clip_to_box(solids.overlapping_box(self.triangles, low, high), low, high)
        points = np.zeros((0, 3))
        if len(near):
            sampled, _ = sample_surface(near, 4 * MOST_POINTS * max(len(places), 1), seed)
            away = np.linalg.norm(sampled[:, None, [0, 2]] - places[None, :, [0, 2]], axis=-1).min(1)
            points = sampled[away < radius]
        if not len(points):  # a ground that is assumed, without triangles
            spread = np.random.default_rng(seed).uniform(-radius, radius, (MOST_POINTS, 2))
            points = np.column_stack([spread[:, 0], np.full(MOST_POINTS, level), spread[:, 1]])
            points[:, [0, 2]] += places[0, [0, 2]]
        rows = np.random.default_rng(seed).permutation(len(points))
        return points[np.resize(rows, MOST_POINTS)]

    def is_solid(self, points: np.ndarray) -> bool:
        """Return whether any of some points (K, 3) is inside something."""
        return bool((self.field.at(points)[0] < 0).any())

    def floors(self, places: np.ndarray, first: float, last: float) -> np.ndarray:
        """Return the heights (T,) of the floor under a pelvis or a foot at places (T, 3), first and last at the ends.

        Between ends of about the same height they are interpolated; otherwise they are those of the ground, such as a
        step or a stair.
        """
        even = np.linspace(first, last, len(places))
        if abs(last - first) < EVEN:
            return even
        numbers = self.mesh.ground.at(np.column_stack([places[:, 0], even, places[:, 2]]))
        heights = self.mesh.ground.points(np.maximum(numbers, 0))[:, 1]
        between = (heights > min(first, last) - EVEN) & (heights < max(first, last) + EVEN)
        found = np.where((numbers >= 0) & between, heights, even)
        found[[0, -1]] = first, last
        return gaussian_filter1d(found, STEPPED, mode="nearest")

    @cached_property
    def field(self) -> SignedDistance:
        """The signed distances of the scene."""
        return around_ground(self.triangles, self.mesh)
