"""The interaction grid: the representation of an object for MotionNet and GoalNet (SAMP, section 3.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from .. import frames
from . import geometry

RESOLUTION = 8
CELLS = RESOLUTION**3
FEATURES = 4 * CELLS
SAMPLES_PER_CELL_SIDE = 16
"""Surface samples along the side of a cell; the closest select the triangles for the exact distance."""
MAX_SAMPLES = 65_536
AROUND_LOW, AROUND_HIGH = (-0.7, 0.0, -0.9), (0.7, 1.4, 0.9)
"""Metres. Corners of the box around a goal: left of it, over the floor, and in front of it. A lying body fits in."""
THINNEST_SIDE = 1e-4
"""Metres. The box of a flat object (a rug, a plane) has at least this thickness."""


@dataclass(frozen=True)
class InteractionGrid:
    """8 x 8 x 8 cells over an object's bounding box, or over a box around a goal, rotated about the vertical.

    centres: (512, 3) cell centres in the network's world frame, metres, in the order x, y, z of the box
    (z varies fastest). occupancy: (512,) from 0 to 1: max(0, 1 - distance to the surface / largest cell side).
    yaw: radians. centre: (3,) and size: (3,) of the box along its own axes, metres.
    """

    centres: np.ndarray
    occupancy: np.ndarray
    yaw: float
    centre: np.ndarray
    size: np.ndarray

    @classmethod
    def build(cls, triangles: np.ndarray, yaw: float = 0.0, name: str = "The object") -> InteractionGrid:
        """Build the grid of triangles (F, 3, 3), network frame. Raises SampError that names an unusable object."""
        triangles = np.asarray(triangles, dtype=np.float64)
        area = geometry.require_surface(triangles, name)
        local = triangles @ frames.yawed_axes(yaw)
        low, high = geometry.bounds(local)
        return cls._filled(local, low, np.maximum(high - low, THINNEST_SIDE), yaw, area)

    @classmethod
    def around(
        cls, triangles: np.ndarray, position: np.ndarray, yaw: float, floor: float = 0.0
    ) -> InteractionGrid:
        """Build the grid of what triangles (F, 3, 3) have around a goal, network frame.

        position: (3,) of the goal, whose height is ignored. yaw: facing of the goal, radians. floor: height of the
        floor, metres. The box has the same size for all objects; what is outside of it is left out.
        """
        axes = frames.yawed_axes(yaw)
        local = np.asarray(triangles, dtype=np.float64) @ axes
        origin = np.array([position[0], floor, position[2]]) @ axes
        low, high = origin + AROUND_LOW, origin + AROUND_HIGH
        size = high - low
        reach = size.max() / RESOLUTION
        near = (local.max(1) >= low - reach).all(1) & (local.min(1) <= high + reach).all(1)
        area = geometry.areas(local[near])
        return cls._filled(local[near][area > 0], low, size, yaw, area[area > 0])

    @classmethod
    def _filled(
        cls, local: np.ndarray, low: np.ndarray, size: np.ndarray, yaw: float, area: np.ndarray
    ) -> InteractionGrid:
        """Build the grid of a box from its lowest corner and its size, from triangles along its axes."""
        cells = low + (_unit_cells() + 0.5) * (size / RESOLUTION)
        largest = size.max() / RESOLUTION
        occupancy = np.zeros(CELLS)
        if len(local):
            distance = surface_distance(cells, local, largest / SAMPLES_PER_CELL_SIDE, area)
            occupancy = np.maximum(0.0, 1.0 - distance / largest)
        back = frames.yawed_axes(yaw).T
        return cls(cells @ back, occupancy, float(yaw), (low + size / 2) @ back, size)

    @property
    def cell_size(self) -> np.ndarray:
        """Side lengths (3,) of a cell along the box's axes, metres."""
        return self.size / RESOLUTION

    def features(
        self, root_position: np.ndarray, root_yaw: np.ndarray | float, floor: float = 0.0
    ) -> np.ndarray:
        """Return network input (..., 2048): for each cell its centre in the root frame (3) and its occupancy (1).

        root_position: (..., 3) of the pelvis, whose height is ignored: the origin of the root frame is below it at
        height ``floor``, metres. root_yaw: (...) of the root frame, radians.
        """
        origin = np.array(root_position, dtype=np.float64)
        origin[..., 1] = floor
        return self._features_from(origin, np.asarray(root_yaw, dtype=np.float64))

    def object_features(self) -> np.ndarray:
        """Return GoalNet's input (2048,): the same numbers in the frame of the box, with the origin at its centre."""
        return self._features_from(self.centre, np.asarray(self.yaw))

    def _features_from(self, origin: np.ndarray, yaw: np.ndarray) -> np.ndarray:
        offset = self.centres - origin[..., None, :]
        cos, sin = np.cos(yaw)[..., None], np.sin(yaw)[..., None]
        x, y, z = np.moveaxis(offset, -1, 0)
        occupancy = np.broadcast_to(self.occupancy, x.shape)
        cells = np.stack([x * cos - z * sin, y, x * sin + z * cos, occupancy], axis=-1)
        return cells.reshape(*cells.shape[:-2], FEATURES)


def surface_distance(
    points: np.ndarray, triangles: np.ndarray, spacing: float, area: np.ndarray | None = None
) -> np.ndarray:
    """Return distances (N,) from points (N, 3) to triangles (F, 3, 3), metres.

    The surface is sampled every ``spacing`` metres (at most 65,536 samples), and the exact distance is computed to the
    triangles of the closest samples: exact on large faces, within about half the spacing on fine ones.
    """
    area = geometry.areas(triangles) if area is None else area
    count = int(np.clip(area.sum() / spacing**2, CELLS, MAX_SAMPLES))
    samples, owner = geometry.spread_over_surface(triangles, count, area)
    tree = cKDTree(samples, balanced_tree=False, compact_nodes=False)
    neighbours = min(8, len(samples))
    _, index = tree.query(points, k=neighbours)
    faces = triangles[owner[index.ravel()]]
    repeated = np.repeat(points, neighbours, axis=0)
    gaps = np.linalg.norm(geometry.closest_points(repeated, faces) - repeated, axis=1)
    return gaps.reshape(len(points), neighbours).min(axis=1)


def _unit_cells() -> np.ndarray:
    return np.indices((RESOLUTION,) * 3).reshape(3, -1).T.astype(np.float64)
