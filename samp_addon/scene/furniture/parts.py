"""Connected parts of triangles, and the pieces of furniture in a room that is one mesh or hangs under one root.

Network frame, metres.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

from .. import geometry
from ..navmesh.lattice import clip_to_box

LARGEST = 4.0
"""Width of the largest piece of furniture; what is wider is a room or a part of its shell."""
TALLEST = 1.9
"""Height of the tallest piece; panels and cupboards as high as a wall are part of the room."""
TOUCHING = 0.02
"""Parts whose boxes are nearer than this are one piece."""
FLAT = 0.06
"""Height over the floor below which a part is a rug, a plank or a tile of it."""
THICKEST = 0.25
"""Thickness of the thickest floor, whose upper side is what is walked on."""
SMALLEST = 0.25
"""Width and depth of the smallest piece that carries a body."""
SMALLEST_ROOM, LOWEST_ROOM = 2.25, 0.5
"""Square metres and height of the smallest diorama."""
SLAB, FLOOR_SHARE = 0.15, 0.8
"""Height of the thickest floor of a diorama, and its least share of the footprint."""
MOST_PARTS = 3000
"""Parts that are grouped; the smaller ones of a room with more stay with the room."""
MEETING_SAMPLES = 2000
"""Points on each of two surfaces that may touch."""
WELD = 1e-4
"""Distance at which corners of triangles are one vertex."""


def labels(corners: np.ndarray, count: int) -> np.ndarray:
    """Return the connected part (F,) of each triangle. corners: (F, 3) indices of vertices, count: of the vertices."""
    pairs = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]]])
    links = sparse.coo_matrix((np.ones(len(pairs), dtype=bool), tuple(pairs.T)), shape=(count, count))
    return np.unique(
        csgraph.connected_components(links, directed=False)[1][corners[:, 0]], return_inverse=True
    )[1]


def welded_labels(triangles: np.ndarray) -> np.ndarray:
    """Return the connected part (F,) of each triangle (F, 3, 3), by the places of its corners."""
    whole = np.round(triangles.reshape(-1, 3) / WELD).astype(np.int64)
    _, corner = np.unique(whole, axis=0, return_inverse=True)
    corner = corner.reshape(-1, 3)
    return labels(corner, int(corner.max()) + 1)


def is_room(triangles: np.ndarray, object_ids: np.ndarray) -> bool:
    """Return whether triangles (F, 3, 3) of objects (F,) are too wide for a piece of furniture, or stand on a floor of
    their own, as a diorama does."""
    low, high = geometry.extent(triangles)
    size = high - low
    if size[[0, 2]].max() > LARGEST:
        return True
    numbers = np.unique(object_ids)
    if len(numbers) < 2 or size[0] * size[2] < SMALLEST_ROOM or size[1] < LOWEST_ROOM:
        return False
    for number in numbers:
        least, most = geometry.extent(triangles[object_ids == number])
        under = most[1] < low[1] + SLAB
        if under and (most - least)[[0, 2]].prod() > FLOOR_SHARE * size[0] * size[2]:
            return True
    return False


def pieces(triangles: np.ndarray, object_ids: np.ndarray) -> tuple[list[np.ndarray], float]:
    """Split a room into pieces of furniture: arrays of indices of triangles, the largest first; and its floor.

    triangles: (F, 3, 3). object_ids: (F,) of the objects; parts of a furniture-sized object stay together.
    Walls, floors, ceilings and flat things on the floor are no pieces.
    """
    part = _parts(triangles, object_ids)
    count = int(part.max()) + 1
    low, high = np.full((2, count, 3), [[[np.inf]], [[-np.inf]]])
    np.minimum.at(low, part, triangles.min(axis=1))
    np.maximum.at(high, part, triangles.max(axis=1))
    floor = _floor(triangles)
    size = high - low
    shell = (size[:, [0, 2]].max(axis=1) > LARGEST) | (size[:, 1] > TALLEST) | (high[:, 1] < floor + FLAT)
    chosen = np.flatnonzero(~shell)
    if len(chosen) > MOST_PARTS:
        chosen = np.sort(chosen[np.argsort(-size[chosen].prod(axis=1))[:MOST_PARTS]])
    group = np.full(count, -1)
    order = np.argsort(part, kind="stable")
    bounds = np.searchsorted(part[order], [chosen, chosen + 1])
    surfaces = [triangles[order[first:last]] for first, last in bounds.T]
    group[chosen] = _touching(low[chosen], high[chosen], surfaces)
    of = group[part]
    found = [np.flatnonzero(of == number) for number in range(int(group.max(initial=-1)) + 1)]
    found = [piece for piece in found if _carries(triangles[piece])]
    return sorted(found, key=lambda piece: -np.prod(np.ptp(triangles[piece], axis=(0, 1))[[0, 2]])), floor


def _parts(triangles: np.ndarray, object_ids: np.ndarray) -> np.ndarray:
    """Return the part (F,) of each triangle: its object, or the connected part of an object as large as a room."""
    part, used = np.zeros(len(triangles), dtype=np.int64), 0
    for number in np.unique(object_ids):
        mine = np.flatnonzero(object_ids == number)
        size = np.ptp(triangles[mine], axis=(0, 1))
        whole = size[[0, 2]].max() <= LARGEST and size[1] <= TALLEST
        label = np.zeros(len(mine), dtype=np.int64) if whole else welded_labels(triangles[mine])
        part[mine] = label + used
        used += int(label.max()) + 1
    return part


def _floor(triangles: np.ndarray) -> float:
    """Return the height of the lowest level surface that is a quarter as large as the room."""
    low, high = geometry.extent(triangles)
    vectors = geometry.area_vectors(triangles)
    level = np.flatnonzero(np.abs(vectors[:, 1]) > 0.9 * np.linalg.norm(vectors, axis=1))
    height = triangles[level, :, 1].mean(axis=1)
    order = np.argsort(height)
    height, area = height[order], np.cumsum(np.abs(vectors[level[order], 1]))
    below = np.searchsorted(height, height + FLAT / 2, side="right") - 1
    above = np.searchsorted(height, height - FLAT / 2)
    within = area[below] - np.where(above > 0, area[above - 1], 0.0) if len(height) else np.zeros(0)
    wide = np.flatnonzero(within > 0.25 * (high - low)[0] * (high - low)[2])
    if not len(wide):
        return float(low[1])
    # A slab's upper side is the floor: the highest such level within its thickness.
    first = height[wide[0]]
    return float(height[wide][height[wide] < first + THICKEST].max())


def _touching(low: np.ndarray, high: np.ndarray, surfaces: list[np.ndarray]) -> np.ndarray:
    """Return the group (N,) of parts that touch each other, directly or by others.

    low, high: (N, 3) of their boxes. surfaces: triangles (F, 3, 3) of each. Boxes side by side touch; where one is
    in the other, as a chair that stands under a table, the surfaces decide.
    """
    rows, columns = [np.arange(len(low))], [np.arange(len(low))]
    for number in range(len(low)):
        near = (low[number + 1 :] <= high[number] + TOUCHING) & (high[number + 1 :] >= low[number] - TOUCHING)
        others = np.flatnonzero(near.all(axis=1)) + number + 1
        shared = np.minimum(high[others], high[number]) - np.maximum(low[others], low[number])
        deep = (shared > TOUCHING).all(axis=1)
        met = [not d or _meet(surfaces[number], surfaces[k]) for d, k in zip(deep, others, strict=True)]
        others = others[np.array(met, dtype=bool)]
        rows.append(np.full(len(others), number))
        columns.append(others)
    row, column = np.concatenate(rows), np.concatenate(columns)
    links = sparse.coo_matrix((np.ones(len(row), dtype=bool), (row, column)), shape=(len(low), len(low)))
    return csgraph.connected_components(links, directed=False)[1]


def _meet(one: np.ndarray, other: np.ndarray) -> bool:
    """Return whether two surfaces (F, 3, 3), (G, 3, 3) come within TOUCHING of each other."""
    bounds = geometry.extent(one), geometry.extent(other)
    low = np.maximum(bounds[0][0], bounds[1][0]) - TOUCHING
    high = np.minimum(bounds[0][1], bounds[1][1]) + TOUCHING
    clipped = [clip_to_box(surface, low, high) for surface in (one, other)]
    if any(len(surface) == 0 or geometry.areas(surface).sum() < geometry.MINIMUM_AREA for surface in clipped):
        return False
    points = [geometry.spread_over_surface(surface, MEETING_SAMPLES)[0] for surface in clipped]
    spacing = max(np.sqrt(geometry.areas(surface).sum() / MEETING_SAMPLES) for surface in clipped)
    return bool(cKDTree(points[0]).query(points[1])[0].min() < max(TOUCHING, spacing))


def _carries(triangles: np.ndarray) -> bool:
    size = np.ptp(triangles, axis=(0, 1))
    return bool(size[[0, 2]].min() >= SMALLEST and size[1] > FLAT and size[[0, 2]].max() <= LARGEST)
