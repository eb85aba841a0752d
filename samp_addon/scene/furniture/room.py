"""The piece of a joined room that is meant: the best seat or bed in a mesh or group that is a whole room."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from ..distance import solids
from ..geometry import SceneGeometry, extent, spread_over_surface
from ..seats import seats
from . import parts

MOST_PIECES = 40
"""Pieces that are tried, the largest ones."""
SAMPLES = 20_000
"""Points on the surface of a piece, to tell which one is under a click."""
AROUND = 1.0
"""Metres around a piece in which other things are in the way."""


def choose(
    scene: SceneGeometry, names: Collection[str], action: str, hint: np.ndarray | None = None
) -> np.ndarray | None:
    """Return the indices of the triangles of a piece that is sat or lain on, or None where there is none.

    names: the objects of the room. hint: a point (3,) in or on the piece that is meant, metres; without one, it is the
    piece with the best place.
    """
    mine = np.flatnonzero(scene.is_one_of(names))
    found, floor = parts.pieces(scene.triangles[mine], scene.object_ids[mine])
    found = [mine[piece] for piece in found]
    if hint is not None and found:
        return nearest(scene.triangles, found, hint)
    best, most = None, 0.0
    for piece in found[:MOST_PIECES]:
        score = _score(scene, piece, action, floor)
        if score > most:
            best, most = piece, score
    return best


def nearest(triangles: np.ndarray, pieces: list[np.ndarray], point: np.ndarray) -> np.ndarray:
    """Return the piece nearest to a point (3,): by its box and, of those that share it, by its surface."""
    boxes = [extent(triangles[piece]) for piece in pieces]
    away = [float(np.linalg.norm(np.maximum(np.maximum(a - point, point - b), 0))) for a, b in boxes]
    near = [piece for piece, d in zip(pieces, away, strict=True) if d < min(away) + parts.TOUCHING]
    if len(near) == 1:
        return near[0]
    samples = (spread_over_surface(triangles[piece], SAMPLES)[0] for piece in near)
    return near[int(np.argmin([np.linalg.norm(points - point, axis=1).min() for points in samples]))]


def _score(scene: SceneGeometry, piece: np.ndarray, action: str, floor: float) -> float:
    triangles = scene.triangles[piece]
    low, high = extent(triangles)
    others = np.ones(len(scene), dtype=bool)
    others[piece] = False
    around = solids.overlapping_box(scene.triangles[others], low - AROUND, high + AROUND)
    found = seats.find_seats(triangles, action, floor, around, limit=4)
    return found[0].score if found else 0.0
