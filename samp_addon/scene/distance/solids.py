"""What is solid in a scene, and how far places are from its surface. Network frame, metres.

The sign comes from the winding number as seen along the six directions of the axes: how many more surfaces
are left than entered on the way out. Artists' meshes are open (sofas without a bottom, seats of one sheet),
so a place counts as inside where more than half of the six ways out say so. The distance is exact.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..geometry import area_vectors, closest_points, corners, spread_over_surface

PITCH = 0.02
"""Metres. A point 2 cm deep always lies in a cell whose middle is inside too."""

MARGIN = 0.1
_WAYS = 6
_SPACING = 0.02
"""Metres between the surface samples that find the closest triangles."""

_NUDGE = np.array([1.7e-4, 2.9e-4])
"""Cells by which rays pass beside the cells' middles, so that none runs along an edge."""


@dataclass(frozen=True)
class Boxed:
    """Triangles (F, 3, 3) with their bounding boxes, low and high (3, F): asked for parts of them many times."""

    triangles: np.ndarray
    low: np.ndarray
    high: np.ndarray

    @classmethod
    def of(cls, triangles: np.ndarray) -> Boxed:
        """Measures the boxes."""
        corners = [np.ascontiguousarray(triangles[:, k].T) for k in range(3)]
        return cls(triangles, np.minimum.reduce(corners), np.maximum.reduce(corners))

    def overlapping(self, low: np.ndarray, high: np.ndarray, axes: Sequence[int] = (0, 1, 2)) -> np.ndarray:
        """Flags (F,) of the triangles whose boxes come into the box from low (3,) to high (3,) along axes."""
        flags = np.ones(len(self.triangles), bool)
        for k in axes:
            flags &= (self.high[k] >= low[k]) & (self.low[k] <= high[k])
        return flags


def _counts(scene: Boxed, low: np.ndarray, shape: np.ndarray, pitch: float = PITCH) -> Iterator[np.ndarray]:
    """For each of the six ways how many more surfaces are left than entered from each cell: (X, Y, Z)."""
    for axis in range(3):
        crossings = _crossings(scene, low, shape, axis, pitch)
        onwards = np.flip(np.cumsum(np.flip(crossings, axis), axis, dtype=np.int16), axis)
        ahead = np.delete(onwards, 0, axis)  # those beyond a cell
        yield ahead
        yield ahead - np.take(onwards, [0], axis)  # minus those before it


def _grid_over(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corner (3,) and shape (3,) of a grid of cells that holds points (N, 3)."""
    low, high = corners(points)
    low -= MARGIN
    return low, np.ceil((high + MARGIN - low) / PITCH).astype(int)


def free_counts(scene: Boxed, free: np.ndarray) -> list[int]:
    """What each of the six ways counts at places (N, 3) most of which are outside of all solids.

    What stands between them and the sky (walls of one sheet, a room modelled as a box) is no solid.
    """
    low, shape = _grid_over(free)
    places = tuple(np.floor((free - low) / PITCH).astype(int).T)
    return [int(np.median(way[places])) for way in _counts(scene, low, shape)]


def solid_cells(
    scene: Boxed, low: np.ndarray, shape: np.ndarray, free: Sequence[int], pitch: float = PITCH
) -> np.ndarray:
    """Which cells of a box lie inside the scene: flags (X, Y, Z), ``pitch`` metres apart, from the corner low (3,).

    free: see free_counts.
    """
    votes = np.zeros(shape, np.int8)
    for way, outside in zip(_counts(scene, low, shape, pitch), free, strict=True):
        votes += way > outside
    return votes > _WAYS // 2


def _crossings(scene: Boxed, low: np.ndarray, shape: np.ndarray, axis: int, pitch: float) -> np.ndarray:
    """Surfaces that lines through the cells' middles cross along one axis: +1 where a line leaves a solid.

    Shape (X, Y, Z) with one more along the axis: entry k counts the crossings between middles k - 1 and k.
    """
    u, v = (axis + 1) % 3, (axis + 2) % 3
    met = np.flatnonzero(scene.overlapping(low, low + shape * pitch, (u, v)))
    triangles = scene.triangles[met]
    lowest, highest = ((box[[u, v]][:, met].T - low[[u, v]]) / pitch - 0.5 for box in (scene.low, scene.high))
    flat = (triangles[:, :, [u, v]] - low[[u, v]]) / pitch - 0.5  # cell middles at whole numbers
    first = np.maximum(
        np.ceil(lowest - _NUDGE).astype(np.int64), 0
    )  # the middles are nudged into the triangle
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
    """On which side of an edge a cell's middle lies. The middles are nudged: no edge may run through one."""
    nudged = at + _NUDGE
    return _cross(end - start, nudged - start)


class Surface:
    """Exact distances to triangles (F, 3, 3)."""

    def __init__(self, triangles: np.ndarray) -> None:
        area = np.linalg.norm(area_vectors(triangles), axis=-1)
        count = int(np.clip(area.sum() / _SPACING**2, 1000, 2_000_000))
        self._samples, self._owners = spread_over_surface(triangles, count, area)
        self._columns = np.ascontiguousarray(self._samples.T)
        self._tree = cKDTree(self._samples, balanced_tree=False, compact_nodes=False)
        self._triangles = triangles

    def nearest(
        self, points: np.ndarray, neighbours: int = 4, reach: float = np.inf
    ) -> tuple[np.ndarray, np.ndarray]:
        """Distances (N,) of points (N, 3) in metres, infinite beyond reach, and the closest places (N, 3)."""
        near, index = self._tree.query(points, k=neighbours, distance_upper_bound=reach + 2 * _SPACING)
        result, places = np.full(len(points), np.inf), points.copy()
        owners = self._owners[np.minimum(index, len(self._owners) - 1)]
        for k in range(neighbours):
            # A large triangle is often its own next neighbour.
            fresh = np.isfinite(near[:, k]) & (owners[:, :k] != owners[:, k : k + 1]).all(1)
            rows = np.flatnonzero(fresh)
            closest = closest_points(points[rows], self._triangles[owners[rows, k]])
            gap = np.sqrt(np.square(closest - points[rows]) @ np.ones(3))
            better = gap < result[rows]
            result[rows[better]], places[rows[better]] = gap[better], closest[better]
        return np.where(result <= reach, result, np.inf), places

    def candidates(self, points: np.ndarray, reach: float = PITCH) -> np.ndarray:
        """Flags (N,) of points (N, 3) among which all are that lie within reach of the surface; quick."""
        low, high = corners(points)
        cell = max(2 * _SPACING, reach)
        shape = np.floor((high - low) / cell).astype(int) + 1
        near = self.near_cells(low, shape, cell, cell - _SPACING)
        return near[tuple(np.floor((points - low) / cell).astype(np.int64).T)]

    def near_cells(self, low: np.ndarray, shape: np.ndarray, cell: float, reach: float) -> np.ndarray:
        """Flags (X, Y, Z) of cells from low (3,), ``cell`` metres apart, among which all are that hold a place within
        reach of the surface."""
        pad = math.ceil((reach + _SPACING) / cell)
        start, full = low - pad * cell, shape + 2 * pad
        within = np.ones(len(self._samples), bool)
        for k, column in enumerate(self._columns):  # numpy reduces a short last axis slowly
            within &= (column >= start[k]) & (column < start[k] + full[k] * cell)
        marked = np.zeros(full, bool)
        cells = ((self._samples[within] - start) / cell).astype(np.int64)
        marked[tuple(np.minimum(cells, full - 1).T)] = True  # for rounding
        for axis in range(3):
            marked = _widened(np.moveaxis(marked, axis, 0), pad)
            marked = np.moveaxis(marked, 0, axis)
        return marked


def _widened(flags: np.ndarray, by: int) -> np.ndarray:
    """Flags (X, ...) without ``by`` rows at either end, set where one within so many rows was."""
    count = len(flags) - 2 * by
    return np.logical_or.reduce([flags[k : k + count] for k in range(2 * by + 1)])


def near_box(triangles: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Triangles that come into the box from low (3,) to high (3,)."""
    return triangles[((triangles.max(1) >= low) & (triangles.min(1) <= high)).all(-1)]
