"""Signed distance of an artist's scene: metres to the nearest surface, negative inside solids.

The sign is that of the winding number, estimated from signed crossings along the six axis directions (solids.py) after
faces are oriented outwards (orientation.py). Distances are exact at the corners of cells and linear in between; faces
inside the union of all solids, as where a crate stands on the floor, are ignored. Blocks of cells are computed when
first queried, and a scene's blocks are cached. Network frame.
"""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from typing import TYPE_CHECKING

import numpy as np
from scipy.ndimage import distance_transform_edt

from ..geometry import MINIMUM_AREA, areas, extent
from ..navmesh.lattice import clip_to_box
from .orientation import orient_outward
from .solids import BoxedTriangles, Surface, free_counts, solid_cells
from .surface_samples import without_twins

if TYPE_CHECKING:
    from ..navmesh.navmesh import NavMesh

CELL = 0.02
BLOCK = 8
"""Cells along the edge of a block: 16 cm."""

BAND = 0.12
"""Metres. Distances outside of solids are clipped to this."""

FREE = 24
"""Points over walkable ground that decide which side of a surface is outside."""

TILE = 8
"""Blocks along the edge of a tile, whose cells are classified as inside or outside together."""

PAD = 12
"""Cells around a tile that are considered when the nearest outside cell is searched."""

LARGE = 64.0
"""Metres. Of scenes wider than this, only the surroundings of the queried points are computed."""

AROUND = 3.0
"""Metres around the free points that are computed of a large scene."""

CHUNK = 50_000
"""Points whose distances are computed together, few enough for the processor's cache."""

CACHED = 4
"""Number of scenes in the cache."""

_cache: OrderedDict[tuple, SignedDistance] = OrderedDict()


def cached_field(triangles: np.ndarray, free: np.ndarray, floor: float | None = None) -> SignedDistance:
    """Return the distance field of triangles (F, 3, 3), from the cache for triangles that were queried before.

    free: (N, 3) points most of which are outside all solids, see solids.free_counts. floor: height below which
    everything is solid, or None.
    """
    triangles = np.ascontiguousarray(triangles, dtype=np.float64)
    digest = hashlib.blake2b(triangles.tobytes(), digest_size=16).digest()
    oriented = next((field.triangles for key, field in _cache.items() if key[0] == digest), None)
    if oriented is None:
        oriented = orient_outward(without_twins(triangles)[0])
    outside = tuple(free_counts(BoxedTriangles.of(oriented), free)) if len(oriented) else ()
    box = _surroundings(oriented, free)
    key = digest, outside, floor, None if box is None else box.tobytes()
    if key not in _cache:
        _cache[key] = SignedDistance(oriented, outside, floor, box)
    _cache.move_to_end(key)
    while len(_cache) > CACHED:
        _cache.popitem(last=False)
    return _cache[key]


def around_ground(triangles: np.ndarray, mesh: NavMesh) -> SignedDistance:
    """Return the distance field of a scene's triangles (F, 3, 3); what is over its walkable ground is outside."""
    free = mesh.points[:: max(1, len(mesh.points) // FREE)] + [0.0, 1.0, 0.0]
    return cached_field(triangles, free, mesh.laid_ground)


def _surroundings(triangles: np.ndarray, free: np.ndarray) -> np.ndarray | None:
    """Return corners (2, 3) of the box around the free points to which a large scene is cropped, or None."""
    if len(triangles) == 0 or len(free) == 0 or np.subtract(*extent(triangles)[::-1]).max() <= LARGE:
        return None
    low, high = extent(free)
    # Whole metres, so that the takes of a job share their field.
    return np.stack([np.floor(low - AROUND), np.ceil(high + AROUND)])


class SignedDistance:
    """A distance field in blocks of (BLOCK + 1)^3 corner values, computed when first queried."""

    def __init__(
        self,
        triangles: np.ndarray,
        outside: tuple[int, ...],
        floor: float | None = None,
        box: np.ndarray | None = None,
    ) -> None:
        """triangles: (F, 3, 3) facing outwards. outside: result of solids.free_counts. floor: see cached_field. box:
        corners (2, 3) of the part of a large scene that is computed, or None for all."""
        self.triangles, self._outside, self._floor = triangles, list(outside), floor
        near = triangles if box is None else clip_to_box(triangles, *box)
        self._empty = len(near) == 0 or float(areas(near).sum()) < MINIMUM_AREA
        if self._empty:
            return
        self._scene = BoxedTriangles.of(triangles)
        low, high = extent(triangles)
        if box is not None:
            low, high = np.maximum(low, box[0]), np.minimum(high, box[1])
        low, high = low - 2 * BAND, high + 2 * BAND
        self._low = np.floor(low / (CELL * BLOCK)) * (CELL * BLOCK)
        self._shape = np.ceil((high - self._low) / (CELL * BLOCK)).astype(int) + 1
        self._number = np.zeros(self._shape, np.int32)  # index of each block's values; 0: not computed
        self._values = np.full((1, *[BLOCK + 1] * 3), BAND, np.float32)
        self._surface = Surface(near)

    @property
    def memory(self) -> int:
        """Bytes of all blocks."""
        return 0 if self._empty else self._values.nbytes + self._number.nbytes

    def at(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return distances (N,) of points (N, 3) in metres, at most BAND, and their gradients (N, 3)."""
        points = np.asarray(points, dtype=np.float64)
        distance, slope = np.full(len(points), BAND), np.zeros((len(points), 3))
        if self._empty or len(points) == 0:
            return distance, slope
        parts = [slice(first, first + CHUNK) for first in range(0, len(points), CHUNK)]
        self._make(np.unique(np.concatenate([self._missing(points[part]) for part in parts])))
        for part in parts:
            rows, flat, local = self._located(points[part])
            cell = np.minimum(local.astype(int), BLOCK - 1)
            number = self._number.reshape(-1)[flat]
            distance[part][rows], slope[part][rows] = _trilinear(self._values, number, cell, local - cell)
        return distance, slope

    def _missing(self, points: np.ndarray) -> np.ndarray:
        """Return the numbers (M,) of the blocks of points (N, 3) that are not computed yet, with repetitions."""
        _, flat, _ = self._located(points)
        return flat[self._number.reshape(-1)[flat] == 0]

    def _located(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return which of points (N, 3) are in a block (M,), its number among all (M,), and where they are in it, in
        cells (M, 3)."""
        # One array per coordinate: numpy is several times slower along a short last axis.
        at = (points.T - self._low[:, None]) / (CELL * BLOCK)
        block = np.floor(at)
        inside = (block >= 0) & (block < self._shape[:, None])
        rows = np.flatnonzero(inside[0] & inside[1] & inside[2])
        block = block[:, rows]
        x, y, z = block.astype(np.int64)
        flat = (x * self._shape[1] + y) * self._shape[2] + z
        return rows, flat, ((at[:, rows] - block) * BLOCK).T

    def _make(self, flat: np.ndarray) -> None:
        """Compute the blocks with numbers (N,), which are missing, tile by tile."""
        if len(flat) == 0:
            return
        wanted = np.stack(np.unravel_index(flat, self._shape), -1)
        _, tile = np.unique(wanted // TILE, axis=0, return_inverse=True)
        tile = tile.reshape(-1)
        values = []
        for number in range(int(tile.max()) + 1):
            values.append(self._tile(wanted[tile == number]))
        first = len(self._values)
        order = np.concatenate([np.flatnonzero(tile == number) for number in range(int(tile.max()) + 1)])
        self._number.reshape(-1)[flat[order]] = first + np.arange(len(flat))
        self._values = np.concatenate([self._values, *values])

    def _tile(self, blocks: np.ndarray) -> np.ndarray:
        """Compute values (N, 9, 9, 9) of blocks (N, 3) of one tile."""
        steps = np.stack(np.meshgrid(*[np.arange(BLOCK + 1)] * 3, indexing="ij"), -1)
        corner = (blocks.min(0) * BLOCK) * CELL + self._low
        local = ((blocks - blocks.min(0)) * BLOCK)[:, None, None, None] + steps
        local = local.reshape(-1, 3)
        solid = self._solid(corner - PAD * CELL, local.max(0) + 1 + 2 * PAD)
        inside = solid[tuple((local + PAD).T)]
        points = corner + local * CELL
        near = np.flatnonzero(inside | self._surface.candidates(points, BAND))
        distance = np.full(len(points), BAND)
        distance[near] = np.minimum(
            self._surface.nearest(points[near])[0], np.where(inside[near], np.inf, BAND)
        )
        if self._floor is not None:
            distance = np.minimum(distance, np.abs(points[:, 1] - self._floor))
        if inside.any() and not solid.all():
            distance[inside] = _without_hidden_faces(solid, (local + PAD)[inside], distance[inside])
        return np.where(inside, -distance, distance).reshape(len(blocks), *[BLOCK + 1] * 3).astype(np.float32)

    def _solid(self, low: np.ndarray, shape: np.ndarray) -> np.ndarray:
        """Flag the cell corners (X, Y, Z), starting at low (3,), that are inside a solid or below the floor."""
        solid = solid_cells(self._scene, low - CELL / 2, shape, self._outside, CELL)
        if self._floor is not None:
            under = low[1] + np.arange(shape[1]) * CELL < self._floor - CELL / 1000
            solid = solid | under[None, :, None]
        return solid


def _without_hidden_faces(solid: np.ndarray, at: np.ndarray, distance: np.ndarray) -> np.ndarray:
    """Replace distances (N,) of solid cell corners (N, 3) that refer to faces inside the union of all solids."""
    low, high = np.maximum(at.min(0) - PAD, 0), at.max(0) + PAD + 1
    part = solid[low[0] : high[0], low[1] : high[1], low[2] : high[2]]
    if part.all():
        return distance
    away = distance_transform_edt(part)[tuple((at - low).T)] * CELL
    return np.where(distance < away - 1.75 * CELL, away - CELL / 2, distance)


def _trilinear(
    values: np.ndarray, number: np.ndarray, cell: np.ndarray, share: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Interpolate values (N,) and gradients (N, 3), per metre, in cells (N, 3) of blocks (N,).

    share: (N, 3) position inside the cell, from 0 to 1.
    """
    side = BLOCK + 1
    base = ((number * side + cell[:, 0]) * side + cell[:, 1]) * side + cell[:, 2]
    flat = values.reshape(-1)
    corner = {
        (i, j, k): flat[base + (i * side + j) * side + k] for i in (0, 1) for j in (0, 1) for k in (0, 1)
    }
    x, y, z = share.T
    along_z = {(i, j): corner[i, j, 0] * (1 - z) + corner[i, j, 1] * z for i in (0, 1) for j in (0, 1)}
    along_y = {i: along_z[i, 0] * (1 - y) + along_z[i, 1] * y for i in (0, 1)}
    result = along_y[0] * (1 - x) + along_y[1] * x
    dz = {
        i: (corner[i, 0, 1] - corner[i, 0, 0]) * (1 - y) + (corner[i, 1, 1] - corner[i, 1, 0]) * y
        for i in (0, 1)
    }
    dy = {i: along_z[i, 1] - along_z[i, 0] for i in (0, 1)}
    slope = np.stack([along_y[1] - along_y[0], dy[0] * (1 - x) + dy[1] * x, dz[0] * (1 - x) + dz[1] * x], -1)
    return result, slope / CELL
