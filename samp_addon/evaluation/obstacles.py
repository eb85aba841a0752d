"""Penetration depth of points in a scene, cached for the many queries of all takes in it. Network frame, metres.

Solid cells of 2 cm come from scene/distance/solids.py. They are computed in blocks when first queried and cached. Most
points are far from every surface and need only a look-up of their cell; the others get an exact distance.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Sequence
from typing import Any

import numpy as np

from ..scene.distance.point_cells import PointCells
from ..scene.distance.solids import MARGIN, PITCH, SAMPLED, BoxedTriangles, Surface, free_counts, solid_cells
from ..scene.distance.surface_samples import FixedSamples, without_twins
from ..scene.geometry import in_box

CONTACT_DISTANCE = 0.01
"""Metres. Skin closer to a surface than this touches it."""

ROUNDING = 1e-5
"""Metres. Tolerance that keeps soles on the floor from counting as below it."""

_BITS = 5
BLOCK = 1 << _BITS
"""Cells along the edge of a block."""

PADDING = 1.0
"""Metres by which the box of loaded surfaces extends beyond the queried points, likely covering the next take."""

CHUNK = 50_000
"""Points processed together, few enough for the processor's cache."""

MAX_BLOCKS = 1e6
"""Blocks in the bounding box of a query, above which the query is split into halves."""

SAMPLED_PADDING = 0.5
"""Metres by which the box of surface samples extends beyond the asked one, likely covering the next frames."""

SAMPLED_BOXES = 4
"""Boxes of surface samples that are kept."""

RECENT = 4
"""How many floors, and sets of ray counts that mean outside, have their cells and samples kept."""

KEPT = 1
"""Scenes whose obstacles `shared` keeps."""

_INSIDE, _NEAR = 1, 2
_EDGE = BLOCK * PITCH


class Obstacles:
    """The triangles of a scene with cached solid cells and samples. Thread-safe.

    Cached values depend on the scene alone: the measures of a take do not depend on the takes measured before it.
    """

    def __init__(self, triangles: np.ndarray) -> None:
        """triangles: (F, 3, 3) of the scene."""
        # Opposite twins of two-sided faces cancel each other's winding number.
        self._triangles = without_twins(np.asarray(triangles, dtype=np.float64))[0]
        self._tops = self._triangles[..., 1].max(1)
        self._above: OrderedDict[int, _Above] = OrderedDict()
        self._carpets: OrderedDict[float, Surface | None] = OrderedDict()
        self._lock = threading.Lock()

    def depth(self, vertices: np.ndarray, floor: float | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Compute the depth of a body's vertices inside the scene, and which of them touch it.

        vertices: (T, V, 3) metres. floor: height below which everything is solid, or None. The body of the first frame
        is assumed to be outside all solids. Returns depth (T, V), metres, 0 outside, and flags (T, V) of vertices
        inside or less than 1 cm from a surface. Depths over PADDING may be too large.
        """
        depth, touching = self._above_floor(floor).solids.depth(vertices)
        if floor is not None:
            under = floor - vertices[..., 1]
            depth = np.maximum(depth, under)
            touching |= under > -CONTACT_DISTANCE
            self._touch_carpets(vertices, touching, floor)
        return depth, touching

    def samples(self, low: np.ndarray, high: np.ndarray, floor: float | None = None) -> np.ndarray:
        """Return samples (N, 3), 1.5 cm apart, of the surfaces in the box from low (3,) to high (3,).

        Without the floor itself and what is less than 1 cm above it.
        """
        sampled = self._above_floor(floor).sampled
        with self._lock:
            found = sampled.around(low, high)
        if floor is not None:
            low = np.maximum(low, [-np.inf, np.nextafter(floor + CONTACT_DISTANCE, np.inf), -np.inf])
        return found[in_box(found, low, high)]

    def _above_floor(self, floor: float | None) -> _Above:
        """Return the triangles above a floor's own slab and the carpets on it."""
        above = self._tops > (-np.inf if floor is None else floor + CONTACT_DISTANCE)
        # Floors that differ by a few millimetres have the same triangles above them: as many are the same.
        with self._lock:
            return _recent(self._above, int(above.sum()), lambda: _Above(self._triangles[above]))

    def _touch_carpets(self, vertices: np.ndarray, touching: np.ndarray, floor: float) -> None:
        """Flag the vertices (T, V, 3) that touch carpets, surfaces slightly above the floor."""
        with self._lock:
            carpets = _recent(self._carpets, floor, lambda: self._carpets_on(floor))
        if carpets is None:
            return
        row, column = np.nonzero(~touching & (vertices[..., 1] < floor + 2 * CONTACT_DISTANCE))
        if len(row):
            gap, _ = carpets.nearest(vertices[row, column], 2, CONTACT_DISTANCE)
            touching[row, column] = gap <= CONTACT_DISTANCE

    def _carpets_on(self, floor: float) -> Surface | None:
        flat = self._triangles[(self._tops > floor + ROUNDING) & (self._tops <= floor + CONTACT_DISTANCE)]
        return Surface(flat) if len(flat) else None


def _recent(kept: OrderedDict, key: Hashable, make: Callable[[], Any]) -> Any:
    """Return the value kept under a key; make it if it is missing. Only the RECENT values used last are kept."""
    if key not in kept:
        kept[key] = make()
    kept.move_to_end(key)
    while len(kept) > RECENT:
        kept.popitem(last=False)
    return kept[key]


class _Above:
    """Triangles above a floor, as solids and as samples."""

    def __init__(self, triangles: np.ndarray) -> None:
        self.solids, self.sampled = _Solids(triangles), _Sampled(triangles)


class _Sampled:
    """Surface samples of triangles, in boxes."""

    def __init__(self, triangles: np.ndarray) -> None:
        self._samples = FixedSamples(triangles)
        self._boxes: list[tuple[np.ndarray, np.ndarray, PointCells, np.ndarray]] = []

    def around(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Return at least all samples (N, 3) in the box from low (3,) to high (3,)."""
        for begin, end, cells, samples in self._boxes:
            if (low >= begin).all() and (high <= end).all():
                return samples[cells.within(low, high)]
        begin, end = low - SAMPLED_PADDING, high + SAMPLED_PADDING
        samples, _ = self._samples.within(begin, end)
        self._boxes = [(begin, end, PointCells(samples), samples), *self._boxes[: SAMPLED_BOXES - 1]]
        return samples


_shared: list[tuple[np.ndarray, Obstacles]] = []
_shared_lock = threading.Lock()


def shared(triangles: np.ndarray) -> Obstacles:
    """Return the obstacles of a scene's triangles (F, 3, 3), the same ones for equal triangles.

    The takes of a job, and those of the next jobs, are judged, refined and measured in the same scene; its solid cells
    are computed once. The triangles must not be changed in place.
    """
    with _shared_lock:
        for known, obstacles in _shared:
            if known is triangles or np.array_equal(known, triangles):
                return obstacles
        obstacles = Obstacles(triangles)
        _shared[:] = [(triangles, obstacles), *_shared[: KEPT - 1]]
        return obstacles


class _Solids:
    """The solids that triangles enclose."""

    def __init__(self, triangles: np.ndarray) -> None:
        self._scene = BoxedTriangles.of(triangles)
        self._samples = FixedSamples(triangles, SAMPLED)
        self._low = self._high = np.zeros(3)
        self._surface: Surface | None = None
        self._blocks: OrderedDict[tuple[int, ...], _Blocks] = OrderedDict()
        self._lock = threading.Lock()

    def depth(self, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Compute depth and contact; see Obstacles.depth."""
        # One array per coordinate: numpy is several times slower along a short last axis.
        columns = np.ascontiguousarray(vertices.reshape(-1, 3).T, dtype=np.float64)
        depth, touching = np.zeros(columns.shape[1]), np.zeros(columns.shape[1], bool)
        with self._lock:
            surface = self._reach(columns.min(1), columns.max(1))
        if surface is not None:
            free = tuple(free_counts(self._scene, vertices[0]))
            with self._lock:
                blocks = _recent(self._blocks, free, lambda: _Blocks(self._scene, free))
            for start in range(0, len(depth), CHUNK):
                part = slice(start, start + CHUNK)
                depth[part], touching[part] = _point_depth(columns[:, part], blocks, surface)
        return depth.reshape(vertices.shape[:2]), touching.reshape(vertices.shape[:2])

    def _reach(self, low: np.ndarray, high: np.ndarray) -> Surface | None:
        """Return at least all surfaces near the box from low to high (3,), or None without any."""
        if self._surface is not None and (low >= self._low).all() and (high <= self._high).all():
            return self._surface
        some = self._surface is not None
        self._low = np.minimum(low - PADDING, self._low) if some else low - PADDING
        self._high = np.maximum(high + PADDING, self._high) if some else high + PADDING
        # Blocks that contain points of the box extend at most one block beyond it.
        sampled = self._samples.within(self._low - _EDGE - MARGIN, self._high + _EDGE + MARGIN)
        self._surface = Surface(self._scene.triangles, sampled) if len(sampled[0]) else None
        return self._surface


class _Blocks:
    """Flags _INSIDE and _NEAR of a scene's cells, in blocks."""

    def __init__(self, scene: BoxedTriangles, free: Sequence[int]) -> None:
        """free: see solids.free_counts."""
        self._scene, self._free = scene, free
        self._numbers: dict[tuple[int, ...], int] = {}
        self._flags = np.zeros((2, BLOCK**3), np.uint8)  # the first two blocks are all outside and all inside
        self._flags[1] = _INSIDE
        self._count = 2
        self._lock = threading.Lock()

    def at(self, points: np.ndarray, surface: Surface) -> np.ndarray:
        """Return the flags (N,) of the cells of points (3, N). surface: at least all surfaces near the points."""
        cell = np.floor(points * (1 / PITCH)).astype(np.int32)
        block = cell >> _BITS
        low = block.min(1).astype(np.int64)
        shape = block.max(1) - low + 1
        if shape.prod(dtype=float) > MAX_BLOCKS:
            # Takes can jump far: split the points until the parts are compact.
            middle = (low + block.max(1)) // 2
            axis = int(shape.argmax())
            here = block[axis] <= middle[axis]
            flags = np.empty(len(here), np.uint8)
            flags[here], flags[~here] = (self.at(points[:, side], surface) for side in (here, ~here))
            return flags
        place = ((block[0] - low[0]) * shape[1] + (block[1] - low[1])) * shape[2] + (block[2] - low[2])
        numbers = np.zeros(int(np.prod(shape)), np.int32)
        for wanted in np.flatnonzero(np.bincount(place, minlength=len(numbers))):
            numbers[wanted] = self._block_number(
                tuple(int(k) for k in np.unravel_index(wanted, shape) + low), surface
            )
        x, y, z = cell & (BLOCK - 1)
        return self._flags.reshape(-1)[(((numbers[place] << _BITS) + x << _BITS) + y << _BITS) + z]

    def _block_number(self, block: tuple[int, ...], surface: Surface) -> int:
        """Return the index of a block's flags, which are computed if missing."""
        with self._lock:
            if block not in self._numbers:
                self._numbers[block] = self._make_block(np.array(block), surface)
        return self._numbers[block]

    def _make_block(self, block: np.ndarray, surface: Surface) -> int:
        """Compute the flags of a block and return their index."""
        low = block * _EDGE
        if not self._scene.overlapping(low - MARGIN, low + _EDGE + MARGIN).any():
            return int(solid_cells(self._scene, low + _EDGE / 2, np.ones(3, int), self._free).item())
        solid = solid_cells(self._scene, low, np.full(3, BLOCK), self._free)
        near = surface.near_cells(low, np.full(3, BLOCK), PITCH, PITCH)
        if self._count == len(self._flags):
            self._flags = np.concatenate([self._flags, np.empty_like(self._flags)])
        self._flags[self._count] = (solid * _INSIDE + near * _NEAR).reshape(-1)
        self._count += 1
        return self._count - 1


def _point_depth(points: np.ndarray, blocks: _Blocks, surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Return depth (N,) and contact flags (N,) of points (3, N)."""
    flags = blocks.at(points, surface)
    some = np.flatnonzero(flags)
    depth, touching = np.zeros(len(flags)), np.zeros(len(flags), bool)
    if len(some):
        inside = (flags[some] & _INSIDE).astype(bool)
        depth[some], touching[some] = _depth_near(points[:, some].T, inside, blocks, surface)
    return depth, touching


def _depth_near(
    points: np.ndarray, inside: np.ndarray, blocks: _Blocks, surface: Surface
) -> tuple[np.ndarray, np.ndarray]:
    """Return depth (N,) and contact flags (N,) of points (N, 3) that are inside a solid or near a surface.

    Less than a cell from a surface, the flags of a cell are ambiguous: the cell at a point moved away from the surface
    by one cell is used instead.
    """
    gap, places = np.empty(len(points)), np.empty((len(points), 3))
    near = ~inside
    gap[inside], places[inside] = surface.nearest(points[inside])
    gap[near], places[near] = surface.nearest(points[near], 2, PITCH)
    unsure = np.flatnonzero((gap < PITCH) & (gap > ROUNDING))
    if len(unsure):
        away = (points[unsure] - places[unsure]) / gap[unsure, None]
        inside[unsure] = blocks.at((points[unsure] + away * PITCH).T, surface) & _INSIDE
    inside[gap <= ROUNDING] = False
    return np.where(inside, gap, 0.0), inside | (gap <= CONTACT_DISTANCE)
