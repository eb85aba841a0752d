"""The path around the furniture that RouteNet's route departs from. Network frame, metres."""

from __future__ import annotations

import numpy as np

from ...errors import PathError
from ...scene.navmesh import path as paths
from ...scene.navmesh.navmesh import NavMesh

POINTS = 16
"""Points of a path, as models/long_term/guided_route.py takes them."""

NEAR = 0.8
"""Metres between places that need no path."""

OFF_FLOOR = 2.0
"""Metres by which an end may be off walkable floor: seats and beds are."""

SPACING = 0.1
"""Metres between the points at which a straight line is checked."""


def between(mesh: NavMesh, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return points (16, 3), evenly spaced along the path from start (3,) to end (3,); heights are the floor's.

    A straight line where nothing is in between, and where the ends are close together or one of them is on furniture.
    Raises PathError where there is no way.
    """
    begin, last = _on_floor(mesh, start), _on_floor(mesh, end)
    if np.linalg.norm((last - begin)[[0, 2]]) < NEAR or is_free(mesh, begin, last):
        return resampled(np.array([begin, last]))
    found = paths.plan(mesh, begin, last, OFF_FLOOR).waypoints
    return resampled(np.concatenate([begin[None], found, last[None]]))


def is_free(mesh: NavMesh, start: np.ndarray, end: np.ndarray) -> bool:
    """Return whether all of the straight line between two places on the floor can be walked."""
    count = max(int(np.linalg.norm((end - start)[[0, 2]]) / SPACING), 2)
    points = start + np.linspace(0, 1, count)[:, None] * (end - start)
    numbers = mesh.ground.at(points)
    return bool((numbers >= 0).all() and (mesh.pieces.owner[numbers] >= 0).all())


def resampled(points: np.ndarray, count: int = POINTS) -> np.ndarray:
    """Return points (count, 3), evenly spaced along a line (N, 3) seen from above."""
    steps = np.linalg.norm(np.diff(points[:, [0, 2]], axis=0), axis=-1)
    at = np.concatenate([[0], np.cumsum(steps + 1e-9)])
    wanted = np.linspace(0, at[-1], count)
    return np.stack([np.interp(wanted, at, points[:, axis]) for axis in range(3)], -1)


def is_reachable(mesh: NavMesh, start: np.ndarray, end: np.ndarray) -> bool:
    """Return whether a way leads from one place to another."""
    try:
        paths.plan(mesh, start, end, OFF_FLOOR)
    except PathError:
        return False
    return True


def _on_floor(mesh: NavMesh, place: np.ndarray) -> np.ndarray:
    """Return a place (3,) at the height of the nearest floor."""
    number = int(mesh.ground.at(place))
    number = number if number >= 0 else mesh.nearest(place)
    return np.array([place[0], mesh.ground.points(np.array(number))[1], place[2]])
