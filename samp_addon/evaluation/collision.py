"""Penetration, non-collision and contact of a body with the scene's triangles. Network frame, metres.

The sign comes from the winding number as seen along the six directions of the axes: how many more surfaces
are left than entered on the way out. Artists' meshes are open (sofas without a bottom, seats of one sheet),
so a place counts as inside where more than half of the six ways out say so. The distance is exact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..body import human
from ..motion import Motion
from ..scene.geometry import area_vectors, closest_points, spread_over_surface

PITCH = 0.02
"""Metres. A point 2 cm deep always lies in a cell whose middle is inside too."""

CONTACT_DISTANCE = 0.01
DEPTHS = (0.02, 0.05)
_ROUNDING = 1e-5  # metres; soles that stand on the floor are not under it
_WAYS = 6
_LARGEST_GRID = 20_000_000
_SPACING = 0.02
"""Metres between the surface samples that find the closest triangles."""


@dataclass(frozen=True)
class SolidGrid:
    """Which cells of a box lie inside the scene. low: (3,) corner; solid: (X, Y, Z) flags; PITCH apart."""

    low: np.ndarray
    solid: np.ndarray

    @classmethod
    def build(cls, triangles: np.ndarray, low: np.ndarray, high: np.ndarray, free: np.ndarray) -> SolidGrid:
        """Of triangles (F, 3, 3) in the box from low (3,) to high (3,). Surfaces outside the box count too.

        free: (N, 3) places in the box most of which are outside all solids, such as the body's vertices.
        What stands between them and the sky (walls of one sheet, a room modelled as a box) is no solid.
        """
        shape = np.maximum(np.ceil((high - low) / PITCH).astype(int), 1)
        places = tuple(np.clip(np.floor((free - low) / PITCH).astype(int), 0, shape - 1).T)
        votes = np.zeros(shape, np.int8)
        for axis in range(3):
            crossings = _crossings(triangles, low, shape, axis)
            onwards = np.flip(np.cumsum(np.flip(crossings, axis), axis, dtype=np.int16), axis)
            ahead = np.delete(onwards, 0, axis)  # surfaces left over beyond a cell
            behind = ahead - np.take(onwards, [0], axis)  # minus those before it
            for way in (ahead, behind):
                votes += np.clip(way - int(np.median(way[places])), 0, 1).astype(np.int8)
        return cls(np.asarray(low, float), votes > _WAYS // 2)

    def inside(self, points: np.ndarray) -> np.ndarray:
        """Flags (N,) of points (N, 3); outside the box is outside."""
        cell = np.floor((points - self.low) / PITCH).astype(np.int64)
        within = ((cell >= 0) & (cell < self.solid.shape)).all(-1)
        result = np.zeros(len(points), bool)
        result[within] = self.solid[tuple(cell[within].T)]
        return result


def _crossings(triangles: np.ndarray, low: np.ndarray, shape: np.ndarray, axis: int) -> np.ndarray:
    """Surfaces that lines through the cells' middles cross along one axis: +1 where a line leaves a solid.

    Shape (X, Y, Z) with one more along the axis: entry k counts the crossings between middles k - 1 and k.
    """
    u, v = (axis + 1) % 3, (axis + 2) % 3
    flat = (triangles[:, :, [u, v]] - low[[u, v]]) / PITCH - 0.5  # cell middles at whole numbers
    first = np.maximum(np.ceil(flat.min(1)).astype(np.int64), 0)
    last = np.minimum(np.floor(flat.max(1)).astype(np.int64), shape[[u, v]] - 1)
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
    along = (triangles[which][:, :, axis] - low[axis]) / PITCH - 0.5
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
    nudged = at + np.array([1.7e-4, 2.9e-4])
    return _cross(end - start, nudged - start)


class Surface:
    """Exact distances to triangles (F, 3, 3)."""

    def __init__(self, triangles: np.ndarray) -> None:
        area = np.linalg.norm(area_vectors(triangles), axis=-1)
        count = int(np.clip(area.sum() / _SPACING**2, 1000, 2_000_000))
        points, self._owners = spread_over_surface(triangles, count, area)
        self._tree = cKDTree(points, balanced_tree=False, compact_nodes=False)
        self._triangles = triangles

    def distance(self, points: np.ndarray, neighbours: int = 4, reach: float = np.inf) -> np.ndarray:
        """Distances (N,) of points (N, 3), metres; infinite beyond reach."""
        near, index = self._tree.query(points, k=neighbours, distance_upper_bound=reach + 2 * _SPACING)
        result = np.full(len(points), np.inf)
        some = np.flatnonzero(np.isfinite(near[:, 0]))
        for k in range(neighbours):
            rows = some[np.isfinite(near[some, k])]
            triangles = self._triangles[self._owners[index[rows, k]]]
            gap = np.linalg.norm(closest_points(points[rows], triangles) - points[rows], axis=-1)
            result[rows] = np.minimum(result[rows], gap)
        return np.where(result <= reach, result, np.inf)


def near_box(triangles: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Triangles that come into the box from low (3,) to high (3,)."""
    return triangles[((triangles.max(1) >= low) & (triangles.min(1) <= high)).all(-1)]


def body_depth(
    motion: Motion,
    triangles: np.ndarray,
    floor: float | None = None,
    stride: int = 1,
    largest: int = _LARGEST_GRID,
    body: human.Human | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """How deep the body's 2048 collision vertices lie inside the scene, and which touch it.

    triangles: (F, 3, 3) of the scene. floor: height under which all is solid, or None. stride: only each
    stride-th frame. largest: cells of one grid; longer ways are measured in parts. Returns depth (T', 2048)
    in metres, 0 outside, and touching (T', 2048): flags of vertices less than 1 cm from a surface, or inside.
    """
    body = body or human.load()
    vertices = human.skin(body, motion, body.collision)[::stride].astype(np.float64)
    triangles = np.asarray(triangles, dtype=np.float64)
    parts = [_chunk_depth(vertices[chunk], triangles) for chunk in _chunks(vertices, largest)]
    depth, touching = (np.concatenate(both) for both in zip(*parts, strict=True))
    if floor is not None:
        under = floor - vertices[..., 1]
        depth = np.maximum(depth, np.maximum(under, 0.0))
        touching |= under > -CONTACT_DISTANCE
    return depth, touching


def measures(
    motion: Motion,
    triangles: np.ndarray,
    floor: float | None = None,
    stride: int = 1,
    body: human.Human | None = None,
) -> dict[str, float]:
    """Penetration: % of frames with a vertex deeper than 2 and 5 cm, mean and largest of the frames' depths
    in cm; non-collision: share of vertices outside, mean over frames; contact: share of frames that touch."""
    depth, touching = body_depth(motion, triangles, floor, stride, body=body)
    deepest = depth.max(1)
    numbers = {
        f"penetration_{limit * 100:.0f}cm_percent": float((deepest > limit).mean() * 100) for limit in DEPTHS
    }
    numbers["penetration_mean_cm"] = float(deepest.mean() * 100)
    numbers["penetration_max_cm"] = float(deepest.max() * 100)
    numbers["non_collision"] = float((depth <= _ROUNDING).mean())
    numbers["contact"] = float(touching.any(1).mean())
    return numbers


def _chunks(vertices: np.ndarray, largest: int) -> list[slice]:
    """Slices of frames whose boxes hold no more than so many cells each, as far as frames can be parted."""
    waiting, done = [slice(0, len(vertices))], []
    while waiting:
        part = waiting.pop()
        cells = np.prod(np.ptp(vertices[part].reshape(-1, 3), axis=0) / PITCH)
        middle = (part.start + part.stop) // 2
        if cells > largest and middle > part.start:
            waiting += [slice(middle, part.stop), slice(part.start, middle)]
        else:
            done.append(part)
    return done


def _chunk_depth(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Depth and touch flags (T', V) of vertices (T', V, 3)."""
    points = vertices.reshape(-1, 3)
    depth, touching = np.zeros(len(points)), np.zeros(len(points), bool)
    low, high = points.min(0) - 0.1, points.max(0) + 0.1
    close = near_box(triangles, low, high)
    if len(close):
        inside = SolidGrid.build(triangles, low, high, points).inside(points)
        surface = Surface(close)
        depth[inside] = surface.distance(points[inside])
        touching[~inside] = np.isfinite(surface.distance(points[~inside], 2, CONTACT_DISTANCE))
        touching |= inside
    return depth.reshape(vertices.shape[:2]), touching.reshape(vertices.shape[:2])
