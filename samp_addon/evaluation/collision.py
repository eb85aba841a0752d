"""Penetration, non-collision and contact of a body with the scene's triangles. Network frame, metres.

What is solid, and how far a vertex is from its surface, says scene/solids.py.
"""

from __future__ import annotations

import numpy as np

from ..body import human
from ..motion import Motion
from ..scene.solids import MARGIN, PITCH, Boxed, SolidGrid, Surface, free_counts

CONTACT_DISTANCE = 0.01
DEPTHS = (0.02, 0.05)
_ROUNDING = 1e-5  # metres; soles that stand on the floor are not under it
_CHUNK_SECONDS = 0.5
JOINED = 0.8  # share of two chunks' boxes up to which one box for both is no larger work


def body_depth(
    motion: Motion, triangles: np.ndarray, floor: float | None = None, body: human.Human | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """How deep the body's 2048 collision vertices lie inside the scene, and which touch it.

    triangles: (F, 3, 3) of the scene. floor: height under which all is solid, or None. The body of the first
    frame counts as outside of all. Returns depth (T, 2048) in metres, 0 outside, and touching (T, 2048):
    flags of vertices less than 1 cm from a surface, or inside.
    """
    body = body or human.load()
    vertices = human.skin(body, motion, body.collision).astype(np.float64)
    triangles = np.asarray(triangles, dtype=np.float64)
    flat = np.zeros((0, 3, 3))
    if floor is not None:
        # The floor's own slab, and carpets on it, are what `under` below stands for.
        high = triangles[..., 1].max(1) > floor + CONTACT_DISTANCE
        triangles, flat = triangles[high], triangles[~high]
    depth, touching = _depth_in(vertices, triangles, max(int(_CHUNK_SECONDS * motion.fps), 1))
    if floor is not None:
        under = floor - vertices[..., 1]
        depth = np.maximum(depth, np.maximum(under, 0.0))
        touching |= under > -CONTACT_DISTANCE
        _touch_carpets(vertices, touching, flat, floor)
    return depth, touching


def _touch_carpets(vertices: np.ndarray, touching: np.ndarray, flat: np.ndarray, floor: float) -> None:
    """Flags the vertices (T, V, 3) that lie on carpets: triangles (F, 3, 3) that rise over the floor by little."""
    carpets = flat[flat[..., 1].max(1) > floor + _ROUNDING]
    row, column = np.nonzero(~touching & (vertices[..., 1] < floor + 2 * CONTACT_DISTANCE))
    if len(carpets) and len(row):
        gap, _ = Surface(carpets).nearest(vertices[row, column], 2, CONTACT_DISTANCE)
        touching[row, column] = gap <= CONTACT_DISTANCE


def measures(
    motion: Motion, triangles: np.ndarray, floor: float | None = None, body: human.Human | None = None
) -> dict[str, float]:
    """Penetration: % of frames with a vertex deeper than 2 and 5 cm, mean and largest of the frames' depths
    in cm; non-collision: share of vertices outside, mean over frames; contact: share of frames that touch."""
    depth, touching = body_depth(motion, triangles, floor, body)
    deepest = depth.max(1)
    numbers = {
        f"penetration_{limit * 100:.0f}cm_percent": float((deepest > limit).mean() * 100) for limit in DEPTHS
    }
    numbers["penetration_mean_cm"] = float(deepest.mean() * 100)
    numbers["penetration_max_cm"] = float(deepest.max() * 100)
    numbers["non_collision"] = float((depth <= _ROUNDING).mean())
    numbers["contact"] = float(touching.any(1).mean())
    return numbers


def _depth_in(vertices: np.ndarray, triangles: np.ndarray, chunk: int) -> tuple[np.ndarray, np.ndarray]:
    """Depth and touch flags (T, V) of vertices (T, V, 3), by chunks of frames: their boxes are small."""
    depth, touching = np.zeros(vertices.shape[:2]), np.zeros(vertices.shape[:2], bool)
    scene = Boxed.of(triangles)
    low, high = vertices.min((0, 1)) - MARGIN, vertices.max((0, 1)) + MARGIN
    close = triangles[scene.overlapping(low, high)]
    if not len(close):
        return depth, touching
    surface, free = Surface(close), free_counts(scene, vertices[0])
    for part in _parts(vertices, chunk):
        points = vertices[part].reshape(-1, 3)
        low, high = points.min(0) - MARGIN, points.max(0) + MARGIN
        if not scene.overlapping(low, high).any():
            continue
        grid = SolidGrid.build(scene, points, free)
        deep, touch = _point_depth(points, grid, surface)
        depth[part], touching[part] = deep.reshape(-1, depth.shape[1]), touch.reshape(-1, depth.shape[1])
    return depth, touching


def _parts(vertices: np.ndarray, chunk: int) -> list[slice]:
    """Spells of frames of vertices (T, V, 3) that share a grid: chunks, joined where the body hardly moves on."""
    lows, highs = vertices.min(1), vertices.max(1)
    volume = lambda part: float(np.prod(highs[part].max(0) - lows[part].min(0)))
    parts: list[slice] = []
    for start in range(0, len(vertices), chunk):
        part = slice(start, start + chunk)
        both = slice(parts[-1].start, part.stop) if parts else part
        if parts and volume(both) < JOINED * (volume(parts[-1]) + volume(part)):
            parts[-1] = both
        else:
            parts.append(part)
    return parts


def _point_depth(points: np.ndarray, grid: SolidGrid, surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Depth (N,) and touch flags (N,) of points (N, 3).

    Within a cell of a surface the grid is not sure of the side: there it is asked a cell farther away from it.
    """
    inside = grid.inside(points)
    gap = np.full(len(points), np.inf)
    gap[inside], deep_places = surface.nearest(points[inside])
    near = np.flatnonzero(~inside & surface.candidates(points))
    gap[near], near_places = surface.nearest(points[near], 2, PITCH)
    places = points.copy()
    places[inside], places[near] = deep_places, near_places
    unsure = np.flatnonzero((gap < PITCH) & (gap > _ROUNDING))
    away = (points[unsure] - places[unsure]) / gap[unsure, None]
    inside[unsure] = grid.inside(points[unsure] + away * PITCH)
    inside[gap <= _ROUNDING] = False
    return np.where(inside, gap, 0.0), inside | (gap <= CONTACT_DISTANCE)
