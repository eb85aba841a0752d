"""The first surface on a ray through a scene, for what is under a mouse. Network frame, metres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .geometry import SceneGeometry

CHUNK = 64
"""Triangles, neighbours in their object, that share a box."""

PARALLEL = 1e-12
"""Determinant below which a ray is parallel to a triangle."""

SLACK = 1e-6


@dataclass(frozen=True)
class Hit:
    """Where a ray meets a surface. point: (3,). normal: (3,) unit, towards the ray's origin. name: of the object."""

    point: np.ndarray
    normal: np.ndarray
    name: str


class Rays:
    """A scene prepared for rays: boxes around runs of CHUNK triangles, of which few are hit by a ray."""

    def __init__(self, scene: SceneGeometry) -> None:
        self.scene = scene
        count = len(scene)
        # A run does not cross from one object to the next: their triangles lie behind each other.
        edges = np.flatnonzero(np.diff(scene.object_ids, prepend=-1)) if count else np.zeros(0, int)
        runs = zip(edges, [*edges[1:], count][: len(edges)], strict=True)
        self.begins = np.concatenate([np.zeros(0, int), *(np.arange(a, b, CHUNK) for a, b in runs)])
        self.ends = np.append(self.begins[1:], count)
        corners = scene.triangles.min(1), scene.triangles.max(1)
        self.low = np.minimum.reduceat(corners[0], self.begins) if count else np.zeros((0, 3))
        self.high = np.maximum.reduceat(corners[1], self.begins) if count else np.zeros((0, 3))

    def first(self, origin: np.ndarray, direction: np.ndarray) -> Hit | None:
        """Return the first surface on a ray, or None. origin, direction: (3,); the direction has any length."""
        origin, direction = np.asarray(origin, float), np.asarray(direction, float)
        enter = self._entered(origin, direction)
        order = np.argsort(enter)
        order = order[np.isfinite(enter[order])]
        best, found = np.inf, -1
        for begin in range(0, len(order), 32):
            some = order[begin : begin + 32]
            if enter[some[0]] > best:
                break
            rows = self._rows(some)
            at = _distances(self.scene.triangles[rows], origin, direction)
            nearest = int(at.argmin())
            if at[nearest] < best:
                best, found = float(at[nearest]), int(rows[nearest])
        if found < 0:
            return None
        a, b, c = self.scene.triangles[found]
        normal = np.cross(b - a, c - a)
        normal /= max(float(np.linalg.norm(normal)), PARALLEL)
        facing = normal if normal @ direction < 0 else -normal
        return Hit(origin + best * direction, facing, self.scene.names[self.scene.object_ids[found]])

    def in_box(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Return the indices (K,) of the triangles whose boxes overlap that from low (3,) to high (3,)."""
        near = np.flatnonzero(((self.low <= high) & (self.high >= low)).all(1))
        rows = self._rows(near)
        corners = self.scene.triangles[rows]
        return rows[((corners.min(1) <= high) & (corners.max(1) >= low)).all(1)]

    def _rows(self, chunks: np.ndarray) -> np.ndarray:
        """Return the indices of the triangles of some chunks."""
        spans = [np.arange(self.begins[k], self.ends[k]) for k in chunks]
        return np.concatenate([np.zeros(0, int), *spans])

    def _entered(self, origin: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """Return the multiple of the direction at which the ray enters each box, infinity where it misses it."""
        step = np.where(np.abs(direction) < PARALLEL, PARALLEL, direction)
        one, two = (self.low - SLACK - origin) / step, (self.high + SLACK - origin) / step
        enter = np.minimum(one, two).max(1)
        leave = np.maximum(one, two).min(1)
        return np.where((enter <= leave) & (leave >= 0), np.maximum(enter, 0), np.inf)


def _distances(triangles: np.ndarray, origin: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Return the multiple of the direction (N,) at which a ray meets each triangle, infinity where it misses it."""
    edge, other = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    across = np.cross(direction, other)
    size = (edge * across).sum(-1)
    safe = np.where(np.abs(size) < PARALLEL, 1.0, size)
    away = origin - triangles[:, 0]
    u = (away * across).sum(-1) / safe
    along = np.cross(away, edge)
    v = along @ direction / safe
    at = (other * along).sum(-1) / safe
    inside = (np.abs(size) >= PARALLEL) & (u >= -SLACK) & (v >= -SLACK) & (u + v <= 1 + SLACK) & (at > 0)
    return np.where(inside, at, np.inf)
