"""How deep points of the scene are inside a body: the distance to its nearest skin. Network frame, metres.

Vertices of a body see solids; a thin seat, a slat or a wire can pass through a thigh between them. So the scene's
surface is sampled, and the samples inside the skin are measured from there.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..body.human import Human
from ..scene.geometry import area_vectors, closest_points
from ..skeleton import BODY_COUNT, INDEX, PARENTS

NEIGHBOURS = 4
"""Nearest vertices whose triangles are searched for the closest skin."""

SLACK = 0.03
"""Metres by which skin is farther from its bone in a bent pose than in the rest pose."""

UNSURE = 0.02
"""Metres outside of the plane at the nearest vertex within which a point is still searched exactly."""


@dataclass(frozen=True)
class Inside:
    """Points inside a body. index: (N,) into the queried points. depth: (N,) metres to the nearest skin. out: (N, 3)
    unit vectors to it. vertex: (N,) the skin's vertex nearest to each."""

    index: np.ndarray
    depth: np.ndarray
    out: np.ndarray
    vertex: np.ndarray


class SkinSurface:
    """The outer skin of a body, without eyes."""

    def __init__(self, body: Human) -> None:
        self.vertices, self._triangles, self._around = _topology(body)
        self._segments, self._radii = _segments(body)
        self.reach = float(self._radii.max())
        """Metres around the joints that hold the whole body."""

    def near(self, joints: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Return the indices of the points (N, 3) that may be inside a body with joints (J, 3)."""
        low, high = joints[:BODY_COUNT].min(0), joints[:BODY_COUNT].max(0)
        boxed = np.ones(len(points), bool)
        for k in range(3):
            column = points[:, k]
            boxed &= (column >= low[k] - self.reach) & (column <= high[k] + self.reach)
        boxed = np.flatnonzero(boxed)
        found = points[boxed]
        hit = np.zeros(len(boxed), bool)
        for (start, end), radius in zip(joints[self._segments], self._radii, strict=True):
            along = end - start
            share = (found - start) @ along / max(along @ along, 1e-12)
            away = found - (start + np.clip(share, 0, 1)[:, None] * along)
            hit |= np.einsum("ni,ni->n", away, away) < radius**2
        return boxed[hit]

    def inside(self, skin: np.ndarray, points: np.ndarray) -> Inside:
        """Find the points (N, 3) inside the skin. skin: (V, 3) positions of ``vertices``."""
        none = Inside(np.zeros(0, int), np.zeros(0), np.zeros((0, 3)), np.zeros(0, int))
        if not len(points):
            return none
        skin = np.asarray(skin, np.float64)
        tree = cKDTree(skin, balanced_tree=False, compact_nodes=False)
        _, near = tree.query(points, k=NEIGHBOURS)
        normal = area_vectors(skin[self._triangles[self._around[near[:, 0]]]].reshape(-1, 3, 3))
        normal = normal.reshape(len(points), -1, 3).sum(1)
        normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-12)
        height = ((points - skin[near[:, 0]]) * normal).sum(-1)
        rows = np.flatnonzero(height < UNSURE)
        if not len(rows):
            return none
        place, outward = self._closest(skin, points[rows], near[rows])
        away = place - points[rows]
        within = (away * outward).sum(-1) > 0
        rows, away = rows[within], away[within]
        depth = np.linalg.norm(away, axis=-1)
        own = self.vertices[near[rows, 0]]
        return Inside(rows, depth, away / np.maximum(depth, 1e-9)[:, None], own)

    def _closest(
        self, skin: np.ndarray, points: np.ndarray, near: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the closest skin (N, 3) to points (N, 3) and its outward normal (N, 3), not of unit length.

        near: (N, K) nearest vertices. At an edge or a vertex the normals of all triangles that share it are added.
        """
        count = len(points)
        faces = self._around[near].reshape(count, -1)
        corners = skin[self._triangles[faces]]
        spread = np.repeat(points, faces.shape[1], axis=0)
        flat = corners.reshape(-1, 3, 3)
        closest = closest_points(spread, flat).reshape(count, -1, 3)
        gap = np.square(closest - points[:, None]).sum(-1)
        best = gap.argmin(1)
        rows = np.arange(count)
        shared = gap <= (np.sqrt(gap[rows, best]) + 1e-6)[:, None] ** 2
        normals = area_vectors(flat).reshape(count, -1, 3)
        normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-15)
        return closest[rows, best], (normals * shared[..., None]).sum(1)


@functools.lru_cache(maxsize=4)
def surface_of(body: Human) -> SkinSurface:
    """Return the skin of a body, cached for consecutive takes."""
    return SkinSurface(body)


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
