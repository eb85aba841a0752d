"""How deep places lie inside a scene, asked many times: by all frames of all takes in it. Network frame, metres.

What is solid says scene/solids.py, on cells of 2 cm. Cells are made in blocks, as they are asked about, and kept; most
places are far from every surface, and one look into their cell settles it. The others get an exact distance.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence

import numpy as np

from ..scene.distance.solids import MARGIN, PITCH, BoxedTriangles, Surface, free_counts, solid_cells

CONTACT_DISTANCE = 0.01
"""Metres from a surface within which skin touches it."""

ROUNDING = 1e-5
"""Metres; soles that stand on the floor are not under it."""

_BITS = 5
BLOCK = 1 << _BITS
"""Cells along the edge of a block."""

PADDING = 1.0
"""Metres beyond the places asked about over which surfaces are looked at, so that the next take is there too."""

CHUNK = 50_000
"""Places looked at together, few enough for a processor's cache."""

MAX_BLOCKS = 1e6
"""Blocks of a box above which its places are looked at in two halves."""

_INSIDE, _NEAR = 1, 2
_EDGE = BLOCK * PITCH


class Obstacles:
    """A scene's triangles, and what has been found out about them. Several threads may ask."""

    def __init__(self, triangles: np.ndarray) -> None:
        """triangles: (F, 3, 3) of the scene."""
        self._triangles = np.asarray(triangles, dtype=np.float64)
        self._over: dict[float | None, _Solids] = {}
        self._lock = threading.Lock()

    def depth(self, vertices: np.ndarray, floor: float | None = None) -> tuple[np.ndarray, np.ndarray]:
        """How deep a body's vertices (T, V, 3) lie inside the scene, (T, V) metres, 0 outside, and flags (T, V) of
        those less than 1 cm from a surface, or inside.

        floor: height under which all is solid, or None. The body of the first frame counts as outside of all.
        """
        with self._lock:
            if floor not in self._over:
                self._over[floor] = _Solids(self._triangles, floor)
        return self._over[floor].depth(vertices)


class _Solids:
    """What stands on one floor."""

    def __init__(self, triangles: np.ndarray, floor: float | None) -> None:
        self._floor, self._carpets = floor, None
        if floor is not None:
            # The floor's own slab, and carpets on it, are what `under` below stands for.
            top = triangles[..., 1].max(1)
            flat = triangles[(top > floor + ROUNDING) & (top <= floor + CONTACT_DISTANCE)]
            triangles = triangles[top > floor + CONTACT_DISTANCE]
            self._carpets = Surface(flat) if len(flat) else None
        self._scene = BoxedTriangles.of(triangles)
        self._low = self._high = np.zeros(3)
        self._surface: Surface | None = None
        self._blocks: dict[tuple[int, ...], _Blocks] = {}
        self._lock = threading.Lock()

    def depth(self, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See Obstacles.depth."""
        # Columns of their own: numpy is several times slower along a short last axis.
        columns = np.ascontiguousarray(vertices.reshape(-1, 3).T, dtype=np.float64)
        depth, touching = np.zeros(columns.shape[1]), np.zeros(columns.shape[1], bool)
        with self._lock:
            surface = self._reach(columns.min(1), columns.max(1))
        if surface is not None:
            free = tuple(free_counts(self._scene, vertices[0]))
            blocks = self._blocks.setdefault(free, _Blocks(self._scene, free))
            for start in range(0, len(depth), CHUNK):
                part = slice(start, start + CHUNK)
                depth[part], touching[part] = _point_depth(columns[:, part], blocks, surface)
        depth, touching = depth.reshape(vertices.shape[:2]), touching.reshape(vertices.shape[:2])
        if self._floor is not None:
            under = self._floor - vertices[..., 1]
            depth = np.maximum(depth, under)
            touching |= under > -CONTACT_DISTANCE
            self._touch_carpets(vertices, touching)
        return depth, touching

    def _touch_carpets(self, vertices: np.ndarray, touching: np.ndarray) -> None:
        """Flags the vertices (T, V, 3) that lie on carpets: what rises over the floor by little."""
        if self._carpets is None:
            return
        row, column = np.nonzero(~touching & (vertices[..., 1] < self._floor + 2 * CONTACT_DISTANCE))
        if len(row):
            gap, _ = self._carpets.nearest(vertices[row, column], 2, CONTACT_DISTANCE)
            touching[row, column] = gap <= CONTACT_DISTANCE

    def _reach(self, low: np.ndarray, high: np.ndarray) -> Surface | None:
        """All surfaces near a box, and maybe more."""
        if self._surface is not None and (low >= self._low).all() and (high <= self._high).all():
            return self._surface
        some = self._surface is not None
        low = np.minimum(low - PADDING, self._low) if some else low - PADDING
        high = np.maximum(high + PADDING, self._high) if some else high + PADDING
        # Blocks that hold places in the box end within it and one block more.
        close = self._scene.overlapping(low - _EDGE - MARGIN, high + _EDGE + MARGIN)
        self._low, self._high = low, high
        self._surface = Surface(self._scene.triangles[close]) if close.any() else None
        return self._surface


class _Blocks:
    """Flags of a scene's cells, _INSIDE and _NEAR, in blocks."""

    def __init__(self, scene: BoxedTriangles, free: Sequence[int]) -> None:
        """free: see solids.free_counts."""
        self._scene, self._free = scene, free
        self._numbers: dict[tuple[int, ...], int] = {}
        self._flags = np.zeros((2, BLOCK**3), np.uint8)  # the first two are all outside and all inside
        self._flags[1] = _INSIDE
        self._count = 2
        self._lock = threading.Lock()

    def at(self, points: np.ndarray, surface: Surface) -> np.ndarray:
        """The flags (N,) of the cells of points (3, N); surface: all that is near them."""
        cell = np.floor(points * (1 / PITCH)).astype(np.int32)
        block = cell >> _BITS
        low = block.min(1).astype(np.int64)
        shape = block.max(1) - low + 1
        if shape.prod(dtype=float) > MAX_BLOCKS:
            # Takes can leap: half the places, and half again, until none are so far apart.
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
        """Number of a block's flags; they are made where they are not there yet."""
        with self._lock:
            if block not in self._numbers:
                self._numbers[block] = self._make_block(np.array(block), surface)
        return self._numbers[block]

    def _make_block(self, block: np.ndarray, surface: Surface) -> int:
        """Number of the flags of a block, made."""
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
    """Depth (N,) and touch flags (N,) of points (3, N)."""
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
    """Depth (N,) and touch flags (N,) of points (N, 3), inside of something or near a surface.

    Within a cell of a surface the cells are not sure of the side: there it is asked a cell farther away from it.
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
