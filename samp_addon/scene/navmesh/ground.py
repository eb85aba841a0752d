"""The ground: standing places with links to their neighbours and their clearance from obstacles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from .heightfield import Grid, Places

DIRECTIONS = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])
"""Offsets in columns (x, z) of the four neighbours; direction d + 2 is opposite to d."""
ABRUPT = 0.07
"""Metres. A higher step between two cells is a climb, and such ground costs more."""
LARGEST_TOP = 8.0
"""Square metres. A larger raised area is a stage or a storey, not a bed or a table."""
STEEP = 0.12
"""Metres. Ground that rises by more over six cells costs more as well: the round edge of a futon, a steep ramp."""
TOP, LOOK_AROUND = 0.08, 0.6
"""Metres: least height of low furniture over the ground around it, and the radius in which that ground is searched."""
STEP_MARGIN = 0.01
"""Metres. Tolerance that keeps stairs exactly as high as the character's step passable."""


@dataclass(frozen=True)
class Ground:
    """Standing places and how they are connected.

    places: the N standing places. index: (layers, X, Z) their indices by column, -1 where there is none.
    links: (4, N) the neighbour in each of DIRECTIONS that can be stepped to, or -1.
    smooth: (4, N) the links without an abrupt step. clearance: (N,) metres from the centre of the place to the nearest
    obstacle or edge, up to some reach. rough: (N,) flags of places on steep ground, near an abrupt step, or on low
    furniture.
    """

    grid: Grid
    places: Places
    index: np.ndarray
    links: np.ndarray
    smooth: np.ndarray
    clearance: np.ndarray
    rough: np.ndarray

    def points(self, numbers: np.ndarray) -> np.ndarray:
        """Return centres (..., 3) of places on the ground, metres, network frame."""
        x = self.grid.corner[0] + (self.places.x[numbers] + 0.5) * self.grid.cell
        z = self.grid.corner[2] + (self.places.z[numbers] + 0.5) * self.grid.cell
        return np.stack([x, self.places.height[numbers], z], axis=-1)

    def at(self, points: np.ndarray) -> np.ndarray:
        """Return the places (...) nearest in height in the columns of points (..., 3), or -1."""
        x = np.floor((points[..., 0] - self.grid.corner[0]) / self.grid.cell).astype(int)
        z = np.floor((points[..., 2] - self.grid.corner[2]) / self.grid.cell).astype(int)
        inside = (x >= 0) & (z >= 0) & (x < self.grid.shape[0]) & (z < self.grid.shape[1])
        found = self.index[:, np.where(inside, x, 0), np.where(inside, z, 0)]
        gap = np.where(found >= 0, np.abs(self.places.height[found] - points[..., 1]), np.inf)
        best = np.take_along_axis(found, gap.argmin(axis=0)[None], axis=0)[0]
        return np.where(inside, best, -1)


def build(
    grid: Grid, places: Places, step: float, headroom: float, slope: float, radius: float, reach: float
) -> Ground:
    """Connect standing places to a ground.

    step: largest step, metres. headroom: free height, metres. slope: steepest even ground, radians. radius: of the
    character, metres; ground so close to an abrupt step is rough. reach: metres up to which clearance is measured.
    """
    # The outermost columns lack neighbours.
    x, z = places.x, places.z
    inner = np.flatnonzero((x > 0) & (z > 0) & (x < grid.shape[0] - 1) & (z < grid.shape[1] - 1))
    places = Places(*(array[inner] for array in vars(places).values()))
    index = _by_column(grid, places)
    abrupt = max(ABRUPT, grid.cell * np.tan(slope) + grid.level)
    links, smooth = np.full((2, 4, len(places)), -1, dtype=np.int32)
    for direction in (0, 1):
        source, target, rise = _neighbours(places, index, DIRECTIONS[direction], step, headroom / grid.level)
        links[direction, source], links[direction + 2, target] = target, source
        even = rise <= abrupt
        smooth[direction, source[even]], smooth[direction + 2, target[even]] = target[even], source[even]
    climbed = ((links >= 0) & (smooth < 0)).any(axis=0)
    clearance = _clearance(links, int(np.ceil(reach / grid.cell))) * grid.cell
    rough = _dilate(links, climbed, int(round(radius / grid.cell)))
    low, high = _around(links, places.height, 3)
    rough |= high - low > max(STEEP, 6 * grid.cell * np.tan(np.radians(20)))
    rough |= _low_tops(places, links, smooth, rough, grid.cell)
    return Ground(grid, places, index, links, smooth, clearance, rough)


def _by_column(grid: Grid, places: Places) -> np.ndarray:
    column = places.x * grid.shape[1] + places.z
    numbers = np.arange(len(places))
    first = np.append(True, column[1:] != column[:-1]) if len(places) else np.zeros(0, dtype=bool)
    layer = numbers - np.maximum.accumulate(np.where(first, numbers, 0))
    index = np.full((int(layer.max(initial=0)) + 1, *grid.shape), -1, dtype=np.int32)
    index[layer, places.x, places.z] = numbers
    return index


def _neighbours(
    places: Places, index: np.ndarray, direction: np.ndarray, step: float, headroom: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return pairs of places one step apart in a direction, and the height difference (metres) of each pair."""
    sources, targets = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    # Layers of a column are at least the headroom apart, so that at most one of them is within a step.
    for layer in index:
        target = layer[places.x + direction[0], places.z + direction[1]]
        source = np.flatnonzero(target >= 0)
        target = target[source]
        room = np.minimum(places.ceiling[source], places.ceiling[target])
        room = room - np.maximum(places.level[source], places.level[target])
        rise = np.abs(places.height[source] - places.height[target])
        good = (rise <= step + STEP_MARGIN) & (room > headroom)
        sources.append(source[good])
        targets.append(target[good])
    source, target = np.concatenate(sources), np.concatenate(targets)
    return source, target, np.abs(places.height[source] - places.height[target])


def _clearance(links: np.ndarray, reach: int) -> np.ndarray:
    """Compute the distance (N,), in cells, from each place to the near side of the closest blocked column.

    Each place propagates the offset of its closest blocked column to its neighbours. The distance is thus measured
    along the ground, and obstacles on other storeys have no effect.
    """
    offset = _adjacent_blocked_columns(links)
    squared = offset[0] ** 2 + offset[1] ** 2
    changed = np.flatnonzero(np.isfinite(squared))
    for _ in range(reach):
        updated = []
        for direction in range(4):
            # The offset as seen from the neighbour.
            target = links[direction, changed]
            source, target = changed[target >= 0], target[target >= 0]
            shifted = offset[:, source] - DIRECTIONS[direction][:, None]
            length = shifted[0] ** 2 + shifted[1] ** 2  # of whole numbers, so exact
            closer = length < squared[target]
            target = target[closer]
            offset[:, target], squared[target] = shifted[:, closer], length[closer]
            updated.append(target)
        changed = np.unique(np.concatenate(updated))
        if len(changed) == 0:
            break
    return np.minimum(np.hypot(*offset), reach) - 0.5


def _adjacent_blocked_columns(links: np.ndarray) -> np.ndarray:
    """Return offsets (2, N), in columns, to an adjacent blocked column of each place; infinite without one."""
    offset = np.full((2, links.shape[1]), np.inf)
    for direction in range(4):
        following = (direction + 1) % 4
        one, two = links[direction], links[following]
        # Corners first: a blocked side is closer and replaces them.
        corner = (one >= 0) & (two >= 0) & ((links[following, one] < 0) | (links[direction, two] < 0))
        offset[:, corner] = (DIRECTIONS[direction] + DIRECTIONS[following])[:, None]
    for direction in range(4):
        offset[:, links[direction] < 0] = DIRECTIONS[direction][:, None]
    return offset


def _dilate(links: np.ndarray, flags: np.ndarray, rounds: int) -> np.ndarray:
    """Flag the places (N,) within ``rounds`` steps of flagged ones."""
    flags = flags.copy()
    changed = np.flatnonzero(flags)
    for _ in range(rounds):
        near = links[:, changed].ravel()
        near = np.unique(near[near >= 0])
        changed = near[~flags[near]]
        flags[changed] = True
    return flags


def _low_tops(
    places: Places, links: np.ndarray, smooth: np.ndarray, uneven: np.ndarray, cell: float
) -> np.ndarray:
    """Flag the places (N,) on top of low furniture, such as a futon, whose round edges can be walked up.

    Its level top is no larger than LARGEST_TOP and at least TOP over the ground around it. uneven: (N,) flags of the
    places that are not on level ground.
    """
    label = connected(len(places), pairs(smooth, ~uneven))
    count = np.bincount(label)
    height = np.bincount(label, places.height) / count
    small = (count * cell**2 <= LARGEST_TOP)[label] & ~uneven
    rounds = int(np.ceil(LOOK_AROUND / cell))
    near = np.flatnonzero(_dilate(links, small, rounds))
    number = np.full(len(places) + 1, -1)
    number[near] = np.arange(len(near))
    low, high = _around(number[links[:, near]], places.height[near], rounds)
    # For each level part as a whole, which may be larger than the search radius.
    lowest, highest = np.full((2, len(count)), [[np.inf], [-np.inf]])
    np.minimum.at(lowest, label[near], low)
    np.maximum.at(highest, label[near], high)
    return ((height - lowest > TOP) & (highest - height < TOP))[label] & small


def _around(links: np.ndarray, height: np.ndarray, rounds: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and highest ground (N,) within ``rounds`` steps of each place."""
    neighbours = [np.where(target >= 0, target, np.arange(len(height))) for target in links]
    low, high = height, height
    for _ in range(rounds):
        low = np.minimum.reduce([low, *(low[there] for there in neighbours)])
        high = np.maximum.reduce([high, *(high[there] for there in neighbours)])
    return low, high


def pairs(links: np.ndarray, chosen: np.ndarray | None = None) -> np.ndarray:
    """Return the pairs (K, 2) of places that links (4, N) connect; chosen: (N,) flags of the places to consider."""
    found = []
    for target in links[:2]:
        here = np.flatnonzero(target >= 0)
        if chosen is not None:
            here = here[chosen[here] & chosen[target[here]]]
        found.append(np.stack([here, target[here]], axis=1))
    return np.concatenate(found)


def connected(count: int, joined: np.ndarray) -> np.ndarray:
    """Label the components (count,) of a graph with edges ``joined`` (K, 2)."""
    links = sparse.coo_matrix((np.ones(len(joined), dtype=bool), tuple(joined.T)), shape=(count, count))
    return csgraph.connected_components(links, directed=False)[1]
