"""Where a surface supports a body and where it obstructs it: a height map and cumulative counts of solid cells.

Built once for an object, so that the queries of postures.py are table look-ups. Network frame, metres.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import ndimage

from ... import frames
from .. import geometry

CELL = 0.025
"""Metres. Fine enough for the slats of a chair, coarse enough for tables of a few million cells."""
MAX_CELLS = 6_000_000
MAX_SAMPLES = 400_000
MARGIN = 0.95
"""Metres around the object that the map covers, for feet and shins next to it."""
CEILING = 1.75
"""Metres over the floor. Nothing higher touches a body that sits or lies on a surface below 0.9 m."""
STEEPEST = 0.75
"""Least vertical component of the normal of a supporting surface: slopes up to 41 degrees."""
HIGHEST = 0.95
"""Metres over the floor. Higher surfaces, such as an upper bunk, are ignored in favour of those below."""
RING, LARGEST_HOLE = 0.07, 0.12
"""Metres within which a ring around a hole is level, and square metres of the largest hole that a body sits over."""
TALLEST_BACK = 1.4
"""Metres over the floor of the highest back that a body leans on."""
HEADROOM = 0.55
"""Metres of free space over a place that make it accessible from above."""


@dataclass(frozen=True)
class SupportMap:
    """Height map and solid cells of an object, in a frame rotated about the vertical.

    heights: (X, Z) highest supporting surface with headroom, metres over the floor, NaN where there is none.
    counts: (X, Y + 1, Z) solid cells below each level; a difference of two gives obstacles between two heights.
    corner: (2,) x and z of the grid's corner in the rotated frame. cell: metres. yaw: of the rotated frame, radians.
    floor: height of the floor in the world, metres. low, high: (2,) bounds of the object in the rotated frame.
    """

    heights: np.ndarray
    counts: np.ndarray
    corner: np.ndarray
    cell: float
    yaw: float
    floor: float
    low: np.ndarray
    high: np.ndarray

    @classmethod
    def build(
        cls,
        triangles: np.ndarray,
        yaw: float = 0.0,
        floor: float | None = None,
        obstacles: np.ndarray | None = None,
    ) -> SupportMap:
        """Build the map of an object's triangles (F, 3, 3); ``obstacles`` (G, 3, 3) obstruct but do not support.

        yaw: of the grid, radians. floor: height, metres; the lowest point if left out. Raises SampError for an object
        without a surface.
        """
        geometry.require_surface(triangles, "The object")
        axes = frames.yawed_axes(yaw)
        local = np.asarray(triangles, float) @ axes
        bounds = geometry.bounds(local)
        floor = float(bounds[0, 1]) if floor is None else float(floor)
        local[..., 1] -= floor
        low, high = bounds[0, [0, 2]], bounds[1, [0, 2]]
        extent = high - low + 2 * MARGIN
        levels = int(np.ceil(CEILING / CELL))
        cell = max(CELL, float(np.sqrt(extent[0] * extent[1] * levels / MAX_CELLS)))
        corner, size = low - MARGIN, np.ceil(extent / cell).astype(int)
        samples, upward = _samples(local, cell)
        solid = np.zeros((size[0], levels, size[1]), dtype=bool)
        index = _index(samples, corner, cell, solid.shape)
        solid.reshape(-1)[index[index >= 0]] = True
        if obstacles is not None and len(obstacles):
            others = np.asarray(obstacles, float) @ axes
            others[..., 1] -= floor
            others = _near(others, corner, corner + size * cell)
            if len(others):
                others_index = _index(_samples(others, 2 * cell)[0], corner, cell, solid.shape)
                solid.reshape(-1)[others_index[others_index >= 0]] = True
        counts = np.zeros((size[0], levels + 1, size[1]), dtype=np.uint8)
        np.cumsum(solid, axis=1, dtype=np.uint8, out=counts[:, 1:])
        heights = _highest(samples[upward], index[upward], counts)
        return cls(heights, counts, corner, cell, float(yaw), floor, low, high)

    def to_grid(self, points: np.ndarray) -> np.ndarray:
        """Return x and z (..., 2) in the rotated frame of world positions (..., 3)."""
        return (np.asarray(points, float) @ frames.yawed_axes(self.yaw))[..., [0, 2]]

    def to_world(self, places: np.ndarray, height: np.ndarray) -> np.ndarray:
        """Return world positions (..., 3) of x and z (..., 2) in the rotated frame, at heights (...) over the floor."""
        local = np.stack([places[..., 0], height, places[..., 1]], axis=-1)
        world = local @ frames.yawed_axes(self.yaw).T
        world[..., 1] += self.floor
        return world

    def height(self, places: np.ndarray) -> np.ndarray:
        """Return heights (...) of the supporting surface, metres over the floor, at x and z (..., 2)."""
        x, z = self._cells(places)
        return self.heights[x, z]

    @cached_property
    def tops(self) -> np.ndarray:
        """Height (X, Z) of the highest solid cell below TALLEST_BACK, metres over the floor, at any slope."""
        filled = np.diff(self.counts[:, : int(TALLEST_BACK / CELL) + 1], axis=1) != 0
        levels = filled.shape[1] - filled[:, ::-1].argmax(axis=1)
        return np.where(filled.any(axis=1), (levels - 0.5) * CELL, np.nan)

    def top(self, places: np.ndarray) -> np.ndarray:
        """Return the heights (...) of the highest solid thing at x and z (..., 2); see tops."""
        x, z = self._cells(places)
        return self.tops[x, z]

    def blocked(self, places: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Return whether (...) anything solid is at the places (..., 2) between two heights over the floor (...)."""
        x, z = self._cells(places)
        top = self.counts.shape[1] - 1
        a = np.clip(np.ceil(np.asarray(low) / CELL), 0, top).astype(np.intp)
        b = np.clip(np.floor(np.asarray(high) / CELL), 0, top).astype(np.intp)
        return self.counts[x, np.maximum(a, b), z] != self.counts[x, a, z]

    def with_filled_holes(self, levels: tuple[float, float]) -> SupportMap | None:
        """Return the map with small holes in its most extensive level surface filled, or None without any.

        levels: lowest and highest height over the floor of the surface, metres.
        """
        fits = (self.heights >= levels[0]) & (self.heights <= levels[1])
        if not fits.any():
            return None
        count, edges = np.histogram(self.heights[fits], np.arange(levels[0], levels[1] + 2 * CELL, CELL))
        level = float(edges[count.argmax()] + CELL / 2)
        ring = np.abs(self.heights - level) < RING
        closed = ndimage.binary_closing(np.pad(ring, 3), iterations=2)[3:-3, 3:-3]
        label, holes = ndimage.label(ndimage.binary_fill_holes(closed | ring) & ~ring)
        top = self.counts.shape[1] - 1
        risen = self.counts[:, min(int((level + 0.4) / CELL), top)] != self.counts[:, int(level / CELL) + 2]
        heights = self.heights.copy()
        for number in range(1, holes + 1):
            hole = label == number
            if hole.sum() * self.cell**2 <= LARGEST_HOLE and not risen[hole].any():
                heights[hole] = level
        return None if holes == 0 else replace(self, heights=heights)

    def _cells(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        at = np.floor((places - self.corner) / self.cell).astype(np.intp)
        return (
            np.clip(at[..., 0], 0, self.heights.shape[0] - 1),
            np.clip(at[..., 1], 0, self.heights.shape[1] - 1),
        )


def _samples(local: np.ndarray, cell: float) -> tuple[np.ndarray, np.ndarray]:
    """Return surface points (N, 3), at least four per cell, and flags (N,) of those on supporting slopes."""
    vectors = geometry.area_vectors(local)
    area = np.linalg.norm(vectors, axis=1)
    count = int(np.clip(area.sum() / (0.45 * cell) ** 2, 2_000, MAX_SAMPLES))
    points, owner = geometry.spread_over_surface(local, count, area)
    # Either side may be the outer one: the normals of artists' meshes are unreliable.
    flat = np.abs(vectors[:, 1]) > STEEPEST * area
    return points, flat[owner]


def _index(points: np.ndarray, corner: np.ndarray, cell: float, shape: tuple[int, ...]) -> np.ndarray:
    """Return flat indices (N,) of the points' cells, -1 outside the grid."""
    x = np.floor((points[:, 0] - corner[0]) / cell).astype(np.intp)
    y = np.floor(points[:, 1] / CELL).astype(np.intp)
    z = np.floor((points[:, 2] - corner[1]) / cell).astype(np.intp)
    inside = (x >= 0) & (x < shape[0]) & (y >= 0) & (y < shape[1]) & (z >= 0) & (z < shape[2])
    return np.where(inside, (x * shape[1] + y) * shape[2] + z, -1)


def _near(triangles: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the triangles that overlap the grid between floor and ceiling."""
    least, most = triangles.min(axis=1), triangles.max(axis=1)
    keep = (most[:, 1] > CELL) & (least[:, 1] < CEILING)
    for axis, column in enumerate((0, 2)):
        keep &= (most[:, column] > low[axis]) & (least[:, column] < high[axis])
    return triangles[keep]


def _highest(points: np.ndarray, index: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Return the height map (X, Z): the highest supporting sample with headroom in each column, small holes closed."""
    use = (index >= 0) & (points[:, 1] < HIGHEST)
    points, index = points[use], index[use]
    levels, depth = counts.shape[1] - 1, counts.shape[2]
    z, y, x = index % depth, index // depth % levels, index // (depth * levels)
    above = np.minimum(y + int(HEADROOM / CELL), levels)
    # Two cells of tolerance: cushions and slopes rise within their own column.
    free = counts[x, above, z] == counts[x, np.minimum(y + 2, levels), z]
    heights = np.full((counts.shape[0], depth), -np.inf)
    np.maximum.at(heights, (x[free], z[free]), points[free, 1])
    filled = ndimage.grey_closing(heights, size=(3, 3))
    # Gaps between slats and columns without samples take the height of their neighbours, unless something rises there.
    empty = ~np.isfinite(heights) & np.isfinite(filled)
    at = np.nonzero(empty)
    base = np.clip((filled[at] / CELL).astype(np.intp) + 2, 0, levels)
    risen = counts[at[0], np.minimum(base + 20, levels), at[1]] != counts[at[0], base, at[1]]
    filled[at[0][risen], at[1][risen]] = -np.inf
    heights = np.where(empty, filled, heights)
    return np.where(np.isfinite(heights), heights, np.nan)
