"""Rasterise triangles to columns of solid cells, and find the places in each column where a character can stand.

Network frame, metres.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .. import geometry
from . import lattice

BUMP = 0.05
"""Metres. Steep surfaces this close above walkable ground (a carpet's pile) do not block it."""
OPEN_SKY = 1 << 30
"""Ceiling level of columns without a ceiling."""
SPARSE, LARGEST_TABLE = 32, 1 << 25
"""Cells of a grid, for each of its samples and in total, above which cells are found by sorting the samples."""


@dataclass(frozen=True)
class Grid:
    """A grid of columns.

    corner: (3,) lowest corner, metres. cell, level: side and height of a cell, metres. shape: columns along x and z.
    """

    corner: np.ndarray
    cell: float
    level: float
    shape: tuple[int, int]

    @classmethod
    def over(cls, low: np.ndarray, high: np.ndarray, cell: float) -> Grid:
        """Return a grid that contains the box from low (3,) to high (3,), with a margin of one column."""
        level = cell / 2
        # Irregular offsets keep floors and walls at round coordinates inside cells, off their borders.
        corner = np.array([low[0] - 1.37 * cell, low[1] - level / 2, low[2] - 1.37 * cell])
        shape = np.ceil((high - corner)[[0, 2]] / cell).astype(int) + 1
        return cls(corner, cell, level, (int(shape[0]), int(shape[1])))

    def widened(self, low: np.ndarray, high: np.ndarray) -> Grid:
        """Return the grid extended by whole cells to contain the box from low to high (3,)."""
        wanted = Grid.over(low, high, self.cell)
        before = np.maximum(np.ceil((self.corner - wanted.corner)[[0, 2]] / self.cell), 0)
        corner = self.corner - np.array([before[0], 0, before[1]]) * self.cell
        far = np.maximum(self.corner[[0, 2]] + np.array(self.shape) * self.cell, high[[0, 2]] + self.cell)
        shape = np.ceil((far - corner[[0, 2]]) / self.cell - 1e-6).astype(int)
        return replace(self, corner=corner, shape=(int(shape[0]), int(shape[1])))


@dataclass(frozen=True)
class Solid:
    """The cells that surfaces pass through, sorted by column and level.

    column, level: (S,) indices. height: (S,) of a surface point in the cell, metres. flat: (S,) flags of surfaces no
    steeper than the slope.
    """

    column: np.ndarray
    level: np.ndarray
    height: np.ndarray
    flat: np.ndarray

    def moved(self, before: Grid, after: Grid) -> Solid:
        """Return the same cells with the indices of an extended grid."""
        x, z = np.divmod(self.column, before.shape[1])
        skipped = np.rint((before.corner - after.corner)[[0, 2]] / before.cell).astype(np.int64)
        return replace(self, column=(x + skipped[0]) * after.shape[1] + z + skipped[1])


@dataclass(frozen=True)
class Places:
    """Places where a character can stand, sorted by column and level.

    x, z: (N,) columns. level: (N,) of the ground. ceiling: (N,) level of the solid cell above. height: (N,) metres.
    """

    x: np.ndarray
    z: np.ndarray
    level: np.ndarray
    ceiling: np.ndarray
    height: np.ndarray

    def __len__(self) -> int:
        return len(self.x)


def solid_cells(triangles: np.ndarray, grid: Grid, slope: float) -> Solid:
    """Return the cells that triangles (F, 3, 3) pass through. slope: of the steepest walkable ground, radians."""
    corners = geometry.by_corner(triangles)
    x, y, z = geometry.cross(corners[1] - corners[0], corners[2] - corners[0])
    # Either side may face up: the normals of artists' meshes are unreliable.
    even = y * y >= np.cos(slope) ** 2 * (x * x + y * y + z * z)
    points, owner = lattice.sample_triangles(corners, grid.cell * 0.7)
    x, y, z = points.T
    ix, iz = (x - grid.corner[0]) / grid.cell, (z - grid.corner[2]) / grid.cell
    inside = (ix >= 0) & (iz >= 0) & (ix < grid.shape[0]) & (iz < grid.shape[1]) & (y >= grid.corner[1])
    column = ix[inside].astype(np.int64) * grid.shape[1] + iz[inside].astype(np.int64)
    level = ((y[inside] - grid.corner[1]) / grid.level).astype(np.int64)
    return _distinct(column, level, y[inside], even[owner[inside]], grid)


def _distinct(
    column: np.ndarray, level: np.ndarray, height: np.ndarray, flat: np.ndarray, grid: Grid
) -> Solid:
    levels = int(level.max(initial=0)) + 1
    key, cells = column * levels + level, grid.shape[0] * grid.shape[1] * levels
    # Walkable ground takes precedence over a chair leg that ends in the same cell; of equals the last one is taken.
    tabulated = cells <= min(SPARSE * len(key), LARGEST_TABLE)
    found, chosen = (_by_table if tabulated else _by_sorting)(key, flat, cells)
    column, level = np.divmod(found, levels)
    return Solid(column, level, height[chosen], flat[chosen])


def _by_table(key: np.ndarray, flat: np.ndarray, cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the different keys, sorted, and the index of the sample chosen for each; keys are below ``cells``."""
    table = np.full(cells, -1, np.int32)
    # Of repeated keys the last index stays.
    for rows in (np.flatnonzero(~flat), np.flatnonzero(flat)):
        table[key[rows]] = rows
    found = np.flatnonzero(table >= 0)
    return found, table[found]


def _by_sorting(key: np.ndarray, flat: np.ndarray, cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the same as `_by_table` without memory for every cell."""
    bits = len(key).bit_length()
    if cells < 1 << (61 - bits):
        # Sorted as numbers that contain their index, several times as fast as finding the order of the keys.
        order = np.sort(((key * 2 + flat) << bits) + np.arange(len(key)))
        key, chosen = order >> (bits + 1), order & ((1 << bits) - 1)
    else:
        chosen = np.lexsort((flat, key))
        key = key[chosen]
    last = np.flatnonzero(np.append(key[1:] != key[:-1], True)[: len(key)])
    return key[last], chosen[last]


def with_ground(solid: Solid, grid: Grid, height: float) -> Solid:
    """Return the solid cells with level ground at ``height`` metres added in every column."""
    count = grid.shape[0] * grid.shape[1]
    level = np.full(count, int((height - grid.corner[1]) / grid.level))
    return _distinct(
        np.concatenate([solid.column, np.arange(count)]),
        np.concatenate([solid.level, level]),
        np.concatenate([solid.height, np.full(count, height)]),
        np.concatenate([solid.flat, np.ones(count, dtype=bool)]),
        grid,
    )


def standing_places(solid: Solid, grid: Grid, headroom: float) -> Places:
    """Return the places on even ground with more than ``headroom`` metres of free cells above."""
    if len(solid.column) == 0:
        return Places(*np.zeros((4, 0), dtype=np.int64), np.zeros(0))
    same = np.append(solid.column[1:] == solid.column[:-1], False)
    ceiling = np.where(same, np.append(solid.level[1:], 0), OPEN_SKY)
    free = np.flatnonzero(ceiling - solid.level > headroom / grid.level)
    even = _even(solid, grid)
    steep = free[~even[free]]
    even[steep] = _next_to_even(solid, even, steep, grid)
    found = free[even[free]]
    x, z = np.divmod(solid.column[found], grid.shape[1])
    return Places(x, z, solid.level[found], ceiling[found], solid.height[found])


def _even(solid: Solid, grid: Grid) -> np.ndarray:
    """Flag the cells (S,) that are even ground, or less than BUMP above it in the same column."""
    even = solid.flat.copy()
    for back in range(1, int(BUMP / grid.level) + 1):
        near = solid.level[back:] - solid.level[:-back] <= BUMP / grid.level
        even[back:] |= solid.flat[:-back] & near & (solid.column[back:] == solid.column[:-back])
    return even


def _next_to_even(solid: Solid, even: np.ndarray, chosen: np.ndarray, grid: Grid) -> np.ndarray:
    """Flag those of the chosen cells (K,) that are adjacent to even ground of the same height.

    At the edge of a stair, the tread may cover so little of a column that only the riser was sampled there.
    """
    span = int(solid.level.max()) + 3
    known = (solid.column * span + solid.level)[even]
    found = np.zeros(len(chosen), dtype=bool)
    for side in (1, -1, grid.shape[1], -grid.shape[1]):
        for step in (0, 1, -1):
            key = (solid.column[chosen] + side) * span + solid.level[chosen] + step
            at = np.searchsorted(known, key)
            found |= known[np.minimum(at, len(known) - 1)] == key if len(known) else False
    return found
