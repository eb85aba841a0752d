"""How deep points of the scene are inside a body: the distance to its nearest skin. Network frame, metres.

Vertices of a body see solids; a thin seat, a slat or a wire can pass through a thigh between them. So the scene's
surface is sampled, and the samples inside the skin are measured from there.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..body.human import Human
from ..scene.distance.point_cells import PointCells
from ..scene.geometry import area_vectors, closest_points, dot, extent, in_box
from ..skeleton import BODY_COUNT, INDEX, PARENTS

NEIGHBOURS = 4
"""Nearest vertices whose triangles are searched for the closest skin."""

SLACK = 0.03
"""Metres by which skin is farther from its bone in a bent pose than in the rest pose."""

THICKEST = 0.16
"""Metres from the nearest vertex beyond which no point is inside."""

BATCH = 128
"""Points of which the exact depth is computed together."""

FOLD = 0.01
"""Metres of depth from which on a point inside is also nearer to a bone than its skin is."""

UNSURE = 0.02
"""Metres outside of the plane at the nearest vertex within which a point is still searched exactly."""

ABOVE = 1e-5
"""Metres over a plane from which on a point is on its outer side, beyond all rounding."""


@dataclass(frozen=True)
class Inside:
    """Points inside a body.

    index: (N,) into the queried points. depth: (N,) metres to the nearest skin. out: (N, 3) unit vectors to it. vertex:
    (N,) the skin's vertex nearest to each. clearance: metres between the nearest of all points and a vertex.
    """

    index: np.ndarray
    depth: np.ndarray
    out: np.ndarray
    vertex: np.ndarray
    clearance: float


def _nothing(clearance: float) -> Inside:
    return Inside(np.zeros(0, int), np.zeros(0), np.zeros((0, 3)), np.zeros(0, int), clearance)


@dataclass(frozen=True)
class _Candidates:
    """Points that may be inside a body.

    rows: (M,) into the queried points. gap: (M,) metres to the nearest vertex. height: (M,) metres over the plane at
    it. clearance: metres between the nearest of all points and a vertex. near: the nearest vertices (K, NEIGHBOURS) of
    points (K,).
    """

    rows: np.ndarray
    gap: np.ndarray
    height: np.ndarray
    clearance: float
    near: Callable[[np.ndarray], np.ndarray]


class SkinSurface:
    """The outer skin of a body, without eyes."""

    def __init__(self, body: Human) -> None:
        self.vertices, self._triangles, self._around = _topology(body)
        self._segments, self._radii = _segments(body)
        self.reach = float(self._radii.max())
        """Metres around the joints that hold the whole body."""

    def near(self, joints: np.ndarray, points: np.ndarray, cells: PointCells | None = None) -> np.ndarray:
        """Return the indices of the points (N, 3) that may be inside a body with joints (J, 3).

        cells: of the points, which save looking at all of them.
        """
        if cells is None:
            low = joints[:BODY_COUNT].min(0) - self.reach
            high = joints[:BODY_COUNT].max(0) + self.reach
            boxed = np.flatnonzero(((points >= low) & (points <= high)).all(1))
        else:
            boxed = cells.members(self._near_bones(joints, cells.centres, cells.radius))
        return boxed[self._near_bones(joints, points[boxed])]

    def _near_bones(self, joints: np.ndarray, points: np.ndarray, margin: float = 0.0) -> np.ndarray:
        """Flag the points (N, 3) as near to a bone as skin can be, or by a margin farther, metres."""
        # Coordinate by coordinate, without BLAS: its threads wait for each other on a busy machine.
        xyz = np.ascontiguousarray(points.T, dtype=np.float32)[:, None]
        start, end = (np.ascontiguousarray(joints[self._segments[:, k]].T, dtype=np.float32) for k in (0, 1))
        along = (end - start)[..., None]
        offset = xyz - start[..., None]
        share = along[0] * offset[0] + along[1] * offset[1] + along[2] * offset[2]
        share /= np.maximum(along[0] ** 2 + along[1] ** 2 + along[2] ** 2, 1e-12)
        np.clip(share, 0, 1, out=share)
        offset -= along * share
        away = offset[0] ** 2 + offset[1] ** 2 + offset[2] ** 2
        return (away < np.square(self._radii + margin, dtype=np.float32)[:, None]).any(0)

    def inside(self, skin: np.ndarray, points: np.ndarray, joints: np.ndarray) -> Inside:
        """Find the points (N, 3) inside the skin. skin: (V, 3) positions of ``vertices``. joints: (J, 3)."""
        found = self._candidates(skin, points)
        rows, near = self._unclear(skin, points, found)
        if not len(rows):
            return _nothing(found.clearance)
        return self._exact(skin, points, joints, found.rows[rows], near, found.clearance)

    def deepest(self, skin: np.ndarray, points: np.ndarray, joints: np.ndarray) -> float:
        """Return the depth, metres, of the deepest of points (N, 3) inside the skin; 0 without one; see `inside`."""
        found, best = self._candidates(skin, points), 0.0
        rows, near = self._unclear(skin, points, found)
        order = np.argsort(found.height[rows])  # those deepest under the planes at their vertices first
        while len(order):
            part, order = order[:BATCH], order[BATCH:]
            inside = self._exact(skin, points, joints, found.rows[rows[part]], near[part])
            best = max(best, float(inside.depth.max(initial=0.0)))
            # Skin is no farther than its nearest vertex: points whose vertices are nearer than the best depth are left.
            order = order[found.gap[rows[order]] > best]
        return best

    def _unclear(
        self, skin: np.ndarray, points: np.ndarray, found: _Candidates
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return which of the candidates, as indices (M,), `_exact` may find inside, and their nearest vertices (M, K).

        The others are over the planes of all triangles around these vertices, so that the closest of them faces them.
        """
        if not len(found.rows):
            return found.rows, np.zeros((0, NEIGHBOURS), int)
        near, points = found.near(found.rows), points[found.rows]
        used, faces = _numbered(self._around[near].reshape(len(points), -1), len(self._triangles))
        corners = skin[self._triangles[used]]
        normal = area_vectors(corners).T.astype(np.float64)
        normal /= np.maximum(np.sqrt(dot(normal, normal)), 1e-15)
        offset = dot(normal, corners[:, 0].T)
        height = sum(normal[k][faces] * points[:, k : k + 1] for k in range(3)) - offset[faces]
        rows = np.flatnonzero(~(height > ABOVE).all(1))
        return rows, near[rows]

    def _candidates(self, skin: np.ndarray, points: np.ndarray) -> _Candidates:
        """Return the points that may be inside."""
        if len(points):
            low, high = extent(points)
            kept = np.flatnonzero(in_box(skin, low - THICKEST, high + THICKEST))
        if not len(points) or len(kept) < NEIGHBOURS:
            nothing = np.zeros(0)
            return _Candidates(nothing.astype(int), nothing, nothing, np.inf, lambda rows: rows)
        tree = cKDTree(skin[kept], balanced_tree=False, compact_nodes=False)
        gap, first = tree.query(points)
        first = kept[first]
        nearest, back = _numbered(first, len(skin))
        normal = area_vectors(skin[self._triangles[self._around[nearest]]].reshape(-1, 3, 3))
        normal = normal.reshape(len(nearest), -1, 3).sum(1)
        normal = (normal / np.maximum(np.sqrt(dot(normal.T, normal.T)), 1e-12)[:, None]).T
        height = dot((points - skin[first]).T, normal[:, back])
        # Far from a vertex and high over its plane is outside; near it the triangles around decide.
        rows = np.flatnonzero((height < UNSURE) & (gap < THICKEST))
        near = lambda some: kept[tree.query(points[some], k=NEIGHBOURS)[1]]
        return _Candidates(rows, gap[rows], height[rows], float(gap.min()), near)

    def _exact(
        self,
        skin: np.ndarray,
        points: np.ndarray,
        joints: np.ndarray,
        rows: np.ndarray,
        near: np.ndarray,
        clearance: float = 0.0,
    ) -> Inside:
        """Return which of the points with indices (M,) are inside; near: (M, K) their nearest vertices."""
        place, outward = self._closest(skin, points[rows], near)
        away = place - points[rows]
        within = (away * outward).sum(-1) > 0
        depth = np.linalg.norm(away, axis=-1)
        # Where the skin is folded, in the groin of a seated body, its normals point inwards.
        deep = np.flatnonzero(within & (depth > FOLD))
        within[deep] = self._off_bones(joints, points[rows[deep]]) < self._off_bones(joints, place[deep])
        rows, away, depth = rows[within], away[within], depth[within]
        own = self.vertices[near[within, 0]]
        return Inside(rows, depth, away / np.maximum(depth, 1e-9)[:, None], own, clearance)

    def _off_bones(self, joints: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Return the metres between points (N, 3) and the nearest bone of a body with joints (J, 3)."""
        start, end = joints[self._segments[:, 0]], joints[self._segments[:, 1]]
        along = end - start
        offset = points[:, None] - start
        share = (offset * along).sum(-1) / np.maximum(np.square(along).sum(-1), 1e-12)
        return np.linalg.norm(offset - np.clip(share, 0, 1)[..., None] * along, axis=-1).min(
            1, initial=np.inf
        )

    def _closest(
        self, skin: np.ndarray, points: np.ndarray, near: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the closest skin (N, 3) to points (N, 3) and its outward normal (N, 3), not of unit length.

        near: (N, K) nearest vertices. At an edge or a vertex the normals of all triangles that share it are added.
        """
        faces = np.sort(self._around[near].reshape(len(points), -1), axis=1)
        # Each triangle once, since neighbouring vertices share triangles.
        fresh = np.diff(faces, axis=1, prepend=-1) > 0
        row, first = np.nonzero(fresh)[0], np.flatnonzero(fresh)
        times = np.diff(np.append(first, faces.size))
        begin = np.searchsorted(row, np.arange(len(points)))
        corners = skin[self._triangles[faces[fresh]]]
        closest = closest_points(points[row], corners)
        gap = np.square(closest - points[row]) @ np.ones(3)
        least = np.minimum.reduceat(gap, begin)
        nearest = np.flatnonzero(gap == least[row])
        nearest = nearest[np.searchsorted(row[nearest], np.arange(len(points)))]
        shared = gap <= (np.sqrt(least) + 1e-6)[row] ** 2
        normals = area_vectors(corners)
        normals *= (shared * times / np.maximum(np.sqrt(np.square(normals) @ np.ones(3)), 1e-15))[:, None]
        return closest[nearest], np.add.reduceat(normals, begin)


@functools.lru_cache(maxsize=4)
def surface_of(body: Human) -> SkinSurface:
    """Return the skin of a body, cached for consecutive takes."""
    return SkinSurface(body)


def _numbered(values: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the sorted different values, of integers below a count, and for each value its place among them."""
    used = np.zeros(count, bool)
    used[values] = True
    return np.flatnonzero(used), (np.cumsum(used) - 1)[values]


def _topology(body: Human) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the vertices (V,) of the largest connected part of the mesh, its triangles (F, 3) and those around each
    vertex (V, K), padded by repetition; indices into the V vertices."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    quads = body.faces
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[quads[:, 2] != quads[:, 3]][:, [0, 2, 3]]])
    edges = np.concatenate([triangles[:, :2], triangles[:, 1:]])
    size = len(body.vertices)
    graph = coo_matrix((np.ones(len(edges)), edges.T), shape=(size, size))
    _, label = connected_components(graph, directed=False)
    main = np.bincount(label).argmax()
    vertices = np.flatnonzero(label == main)
    renumbered = np.full(size, -1)
    renumbered[vertices] = np.arange(len(vertices))
    triangles = renumbered[triangles[label[triangles[:, 0]] == main]]
    owner = triangles.reshape(-1)
    order = np.argsort(owner, kind="stable")
    count = np.bincount(owner, minlength=len(vertices))
    first = np.cumsum(count) - count
    column = np.minimum(np.arange(count.max()), count[:, None] - 1)
    return vertices, triangles, (order // 3)[first[:, None] + column]


def _segments(body: Human) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends (S, 2) of the bones, as joints, and the metres (S,) around them that hold the whole body."""
    kept = [*range(1, BODY_COUNT), *(INDEX[f"{side}_middle1"] for side in ("left", "right"))]
    ends = np.array([(PARENTS[j], j) for j in kept])
    start, end = body.joints[ends[:, 0]], body.joints[ends[:, 1]]
    along = end - start
    share = np.einsum("vsi,si->vs", body.vertices[:, None] - start, along)
    share = np.clip(share / np.maximum(np.square(along).sum(-1), 1e-12), 0, 1)
    away = np.linalg.norm(body.vertices[:, None] - (start + share[..., None] * along), axis=-1)
    nearest = away.argmin(1)
    radii = np.zeros(len(ends))
    np.maximum.at(radii, nearest, away[np.arange(len(away)), nearest])
    used = radii > 0
    return ends[used], radii[used] + SLACK
