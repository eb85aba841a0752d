"""The interaction grid: how MotionNet and GoalNet see an object (SAMP paper, section 3.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from . import geometry

RESOLUTION = 8
CELLS = RESOLUTION**3
FEATURES = 4 * CELLS
SAMPLES_PER_CELL_SIDE = 16
"""Surface samples along a cell's side; the closest name the triangles to measure exactly."""
MOST_SAMPLES = 65_536
THINNEST_SIDE = 1e-4
"""Metres. A flat object (a rug, a bare plane) gets a box of at least this thickness."""


@dataclass(frozen=True)
class InteractionGrid:
    """8 x 8 x 8 cells over an object's bounding box, which is turned about the vertical by ``yaw``.

    centres: (512, 3) cell centres in the network's world frame, metres, in the order x, y, z of the box
    (z runs fastest). occupancy: (512,) from 0 to 1: max(0, 1 - distance to the surface / largest cell side).
    yaw: radians. centre: (3,) and size: (3,) of the box along its own axes, metres.
    """

    centres: np.ndarray
    occupancy: np.ndarray
    yaw: float
    centre: np.ndarray
    size: np.ndarray

    @classmethod
    def build(cls, triangles: np.ndarray, yaw: float = 0.0, name: str = "The object") -> InteractionGrid:
        """Grid of triangles (F, 3, 3), network frame. Raises SampError that names an unusable object."""
        triangles = np.asarray(triangles, dtype=np.float64)
        area = geometry.require_surface(triangles, name)
        local = triangles @ _turn(yaw)
        low, high = geometry.bounds(local)
        size = np.maximum(high - low, THINNEST_SIDE)
        cells = low + (_unit_cells() + 0.5) * (size / RESOLUTION)
        largest = size.max() / RESOLUTION
        distance = surface_distance(cells, local, largest / SAMPLES_PER_CELL_SIDE, area)
        back = _turn(yaw).T
        return cls(
            centres=cells @ back,
            occupancy=np.maximum(0.0, 1.0 - distance / largest),
            yaw=float(yaw),
            centre=(low + size / 2) @ back,
            size=size,
        )

    @property
    def cell_size(self) -> np.ndarray:
        """Sides (3,) of a cell along the box's axes, metres."""
        return self.size / RESOLUTION

    def features(
        self, root_position: np.ndarray, root_yaw: np.ndarray | float, floor: float = 0.0
    ) -> np.ndarray:
        """Network input (..., 2048): for each cell its centre in the root frame (3) and its occupancy (1).

        root_position: (..., 3), of which the height is not used: the root frame stands at ``floor`` (metres)
        below the pelvis, turned by root_yaw (...), radians. Many characters may be asked for at once.
        """
        origin = np.array(root_position, dtype=np.float64)
        origin[..., 1] = floor
        return self._seen_from(origin, np.asarray(root_yaw, dtype=np.float64))

    def object_features(self) -> np.ndarray:
        """GoalNet's input (2048,): the same numbers in the frame of the box's centre, turned as the box."""
        return self._seen_from(self.centre, np.asarray(self.yaw))

    def _seen_from(self, origin: np.ndarray, yaw: np.ndarray) -> np.ndarray:
        offset = self.centres - origin[..., None, :]
        cos, sin = np.cos(yaw)[..., None], np.sin(yaw)[..., None]
        x, y, z = np.moveaxis(offset, -1, 0)
        occupancy = np.broadcast_to(self.occupancy, x.shape)
        seen = np.stack([x * cos - z * sin, y, x * sin + z * cos, occupancy], axis=-1)
        return seen.reshape(*seen.shape[:-2], FEATURES)


def surface_distance(
    points: np.ndarray, triangles: np.ndarray, spacing: float, area: np.ndarray | None = None
) -> np.ndarray:
    """Distances (N,) from points (N, 3) to the closest place on triangles (F, 3, 3), metres.

    The surface is sampled every ``spacing`` metres (at most 65,536 samples), and the exact distance is taken
    to the triangles of the closest samples: exact on large faces, within about half the spacing on fine ones.
    """
    area = geometry.areas(triangles) if area is None else area
    count = int(np.clip(area.sum() / spacing**2, CELLS, MOST_SAMPLES))
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


def _turn(yaw: float) -> np.ndarray:
    """Row vectors times this matrix are expressed in a frame that is turned by yaw about the vertical."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
