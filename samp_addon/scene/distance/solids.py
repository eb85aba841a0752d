"""Solid cells of a scene, and exact distances to its surface. Network frame, metres.

Inside and outside follow from the winding number along the six axis directions: the number of surfaces left minus the
number entered by a ray to infinity. Artists' meshes are open (sofas without a bottom, seats of one sheet), so a point
counts as inside where more than half of the six rays agree, the one that points up among them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..geometry import area_vectors, closest_points, extent, spread_over_surface

PITCH = 0.02
"""Metres. A point 2 cm deep always lies in a cell whose centre is inside as well."""

MARGIN = 0.1
_DIRECTIONS, _UP = 6, 2
"""Number of directions of rays, and the one that points up."""

SAMPLED = 0.02
"""Metres between the surface samples that find the closest triangles."""

_NUDGE = np.array([1.7e-4, 2.9e-4])
"""Cells. Rays are offset from the cell centres by this, so that none runs along an edge."""


@dataclass(frozen=True)
class BoxedTriangles:
    """Triangles (F, 3, 3) with their bounding boxes, low and high (3, F), for repeated box queries."""

    triangles: np.ndarray
    low: np.ndarray
    high: np.ndarray

    @classmethod
    def of(cls, triangles: np.ndarray) -> BoxedTriangles:
        """Compute the bounding boxes of triangles (F, 3, 3)."""
        corners = [np.ascontiguousarray(triangles[:, k].T) for k in range(3)]
        return cls(triangles, np.minimum.reduce(corners), np.maximum.reduce(corners))

    def overlapping(self, low: np.ndarray, high: np.ndarray, axes: Sequence[int] = (0, 1, 2)) -> np.ndarray:
        """Flag the triangles (F,) whose boxes overlap the box from low (3,) to high (3,) along the given axes."""
        flags = np.ones(len(self.triangles), bool)
        for k in axes:
            flags &= (self.high[k] >= low[k]) & (self.low[k] <= high[k])
        return flags


def _counts(
    scene: BoxedTriangles, low: np.ndarray, shape: np.ndarray, pitch: float = PITCH
) -> Iterator[np.ndarray]:
    """Yield, for each of the six directions, surfaces left minus surfaces entered from each cell: (X, Y, Z)."""
    for axis in range(3):
        crossings = _crossings(scene, low, shape, axis, pitch)
        onwards = np.flip(np.cumsum(np.flip(crossings, axis), axis, dtype=np.int16), axis)
        ahead = np.delete(onwards, 0, axis)  # crossings beyond each cell
        yield ahead
        yield ahead - np.take(onwards, [0], axis)  # minus the crossings before it


def _grid_over(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return lowest corner (3,) and shape (3,) of a grid of cells that contains points (N, 3)."""
    low, high = extent(points)
    low -= MARGIN
    return low, np.ceil((high + MARGIN - low) / PITCH).astype(int)


def free_counts(scene: BoxedTriangles, free: np.ndarray) -> list[int]:
    """Return the median count of each of the six directions at points (N, 3), most of which are outside all solids.

    These counts define outside: surfaces between such points and infinity (single-sheet walls, a room modelled as a
    box) do not make the room solid.
    """
    low, shape = _grid_over(free)
    cells = tuple(np.floor((free - low) / PITCH).astype(int).T)
    return [int(np.median(counts[cells])) for counts in _counts(scene, low, shape)]


def solid_cells(
    scene: BoxedTriangles, low: np.ndarray, shape: np.ndarray, free: Sequence[int], pitch: float = PITCH
) -> np.ndarray:
    """Flag the cells (X, Y, Z) inside the scene, of a grid with lowest corner low (3,) and cells of ``pitch`` metres.

    What is open upwards is not solid, but holds what lies in it: a hammock, a bath. free: result of free_counts.
    """
    votes, covered = np.zeros(shape, np.int8), np.zeros(shape, bool)
    for direction, (counts, outside) in enumerate(zip(_counts(scene, low, shape, pitch), free, strict=True)):
        inside = counts > outside
        votes += inside
        if direction == _UP:
            # Cells on the bottom of a solid see it as a whole above them.
            covered = inside.copy()
            covered[:, :-1] |= inside[:, 1:]
    return covered & (votes > _DIRECTIONS // 2)


def _crossings(
    scene: BoxedTriangles, low: np.ndarray, shape: np.ndarray, axis: int, pitch: float
) -> np.ndarray:
    """Count the surfaces that lines through the cell centres cross along one axis: +1 where a line leaves a solid.

    Shape (X, Y, Z) with one more along the axis: entry k counts the crossings between centres k - 1 and k.
    """
    u, v = (axis + 1) % 3, (axis + 2) % 3
    met = np.flatnonzero(scene.overlapping(low, low + shape * pitch, (u, v)))
    triangles = scene.triangles[met]
    lowest, highest = ((box[[u, v]][:, met].T - low[[u, v]]) / pitch - 0.5 for box in (scene.low, scene.high))
    flat = (triangles[:, :, [u, v]] - low[[u, v]]) / pitch - 0.5  # cell centres at integers
    first = np.maximum(
        np.ceil(lowest - _NUDGE).astype(np.int64), 0
    )  # the centres are nudged into the triangle
    last = np.minimum(np.floor(highest).astype(np.int64), shape[[u, v]] - 1)
    span = np.maximum(last - first + 1, 0)
    count = span[:, 0] * span[:, 1]
    which = np.repeat(np.arange(len(triangles)), count)
    order = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    width = span[which, 1]
    at = np.stack(
        [first[which, 0] + order // np.maximum(width, 1), first[which, 1] + order % np.maximum(width, 1)], -1
    )
    a, b, c = (flat[which, k] for k in range(3))
    twice = _cross(b - a, c - a)
    sides = (_edge(a, b, at), _edge(b, c, at), _edge(c, a, at))
    turned = np.sign(twice)
    hit = (turned != 0) & (sides[0] * turned > 0) & (sides[1] * turned > 0) & (sides[2] * turned > 0)
    which, at, turned, twice = which[hit], at[hit], turned[hit], twice[hit]
    along = (triangles[which][:, :, axis] - low[axis]) / pitch - 0.5
    weights = np.stack([sides[1][hit], sides[2][hit], sides[0][hit]], -1) / twice[:, None]
    height = np.clip(np.ceil((along * weights).sum(-1)), 0, shape[axis]).astype(np.int64)
    size = shape.copy()
    size[axis] += 1
    cell = np.empty((len(which), 3), np.int64)
    cell[:, axis], cell[:, u], cell[:, v] = height, at[:, 0], at[:, 1]
    flat_index = np.ravel_multi_index(tuple(cell.T), tuple(size))
    counts = np.bincount(flat_index, weights=turned, minlength=int(np.prod(size)))
    return counts.astype(np.int16).reshape(size)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _edge(start: np.ndarray, end: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return the side of an edge on which a cell centre lies; centres are nudged so that no edge runs through one."""
    nudged = at + _NUDGE
    return _cross(end - start, nudged - start)


class Surface:
    """A surface for exact distance queries."""

    def __init__(self, triangles: np.ndarray, sampled: tuple[np.ndarray, np.ndarray] | None = None) -> None:
        """triangles: (F, 3, 3). sampled: samples (N, 3) of them, SAMPLED metres apart, and their triangles (N,), where
        only a part of the surface is asked about."""
        self._samples, self._owners = sampled or _spread(triangles)
        self._columns = np.ascontiguousarray(self._samples.T)
        # Compact, balanced nodes: points deep inside a solid are equally far from much of its surface.
        self._tree = cKDTree(self._samples)
        self._triangles = triangles

    def nearest(
        self, points: np.ndarray, neighbours: int = 4, reach: float = np.inf
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return distances (N,) of points (N, 3) in metres and the closest surface points (N, 3).

        Distances beyond ``reach`` are infinite. neighbours: surface samples per point whose triangles are tested.
        """
        near, index = self._tree.query(points, k=neighbours, distance_upper_bound=reach + 2 * SAMPLED)
        result, places = np.full(len(points), np.inf), points.copy()
        owners = self._owners[np.minimum(index, len(self._owners) - 1)]
        for k in range(neighbours):
            # Several samples often belong to the same large triangle.
            fresh = np.isfinite(near[:, k]) & (owners[:, :k] != owners[:, k : k + 1]).all(1)
            rows = np.flatnonzero(fresh)
            closest = closest_points(points[rows], self._triangles[owners[rows, k]])
            gap = np.sqrt(np.square(closest - points[rows]) @ np.ones(3))
            better = gap < result[rows]
            result[rows[better]], places[rows[better]] = gap[better], closest[better]
        return np.where(result <= reach, result, np.inf), places

    def candidates(self, points: np.ndarray, reach: float = PITCH) -> np.ndarray:
        """Flag, conservatively and fast, the points (N,) of (N, 3) that may lie within reach of the surface."""
        low, high = extent(points)
        cell = max(2 * SAMPLED, reach)
        shape = np.floor((high - low) / cell).astype(int) + 1
        near = self.near_cells(low, shape, cell, cell - SAMPLED)
        return near[tuple(np.floor((points - low) / cell).astype(np.int64).T)]

    def near_cells(self, low: np.ndarray, shape: np.ndarray, cell: float, reach: float) -> np.ndarray:
        """Flag, conservatively, the cells (X, Y, Z) that may contain a point within reach of the surface.

        low: (3,) lowest corner of the grid. cell: side of a cell, metres.
        """
        pad = math.ceil((reach + SAMPLED) / cell)
        start, full = low - pad * cell, shape + 2 * pad
        within = np.ones(len(self._samples), bool)
        for k, column in enumerate(self._columns):  # numpy reduces a short last axis slowly
            within &= (column >= start[k]) & (column < start[k] + full[k] * cell)
        marked = np.zeros(full, bool)
        cells = ((self._samples[within] - start) / cell).astype(np.int64)
        marked[tuple(np.minimum(cells, full - 1).T)] = True  # against rounding
        for axis in range(3):
            marked = _dilate(np.moveaxis(marked, axis, 0), pad)
            marked = np.moveaxis(marked, 0, axis)
        return marked


def _spread(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return samples (N, 3) of triangles (F, 3, 3), SAMPLED metres apart, and the triangles (N,) of each."""
    area = np.linalg.norm(area_vectors(triangles), axis=-1)
    count = int(np.clip(area.sum() / SAMPLED**2, 1000, 2_000_000))
    return spread_over_surface(triangles, count, area)


def _dilate(flags: np.ndarray, by: int) -> np.ndarray:
    """Dilate flags (X, ...) by ``by`` rows along the first axis and crop ``by`` rows at either end."""
    count = len(flags) - 2 * by
    return np.logical_or.reduce([flags[k : k + count] for k in range(2 * by + 1)])


def overlapping_box(triangles: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the triangles whose bounding boxes overlap the box from low (3,) to high (3,)."""
    return triangles[((triangles.max(1) >= low) & (triangles.min(1) <= high)).all(-1)]
