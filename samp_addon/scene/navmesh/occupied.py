"""The walkable ground without the places where other bodies stand or sit. Network frame, metres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...errors import PathError
from . import islands, rectangles
from .navmesh import PELVIS, NavMesh

Disc = tuple[np.ndarray, float]
"""Centre (3,) on the ground, and radius of a body, metres."""


def without(mesh: NavMesh, discs: Sequence[Disc]) -> NavMesh:
    """Return the navmesh with bodies on it, to be walked around. Raise PathError where nothing is left."""
    if not len(discs):
        return mesh
    points = mesh.ground.points(np.arange(len(mesh.ground.places)))
    clearance = mesh.ground.clearance.copy()
    for centre, radius in discs:
        away = np.hypot(*(points - centre).T[[0, 2]]) - radius
        same = np.abs(points[:, 1] - centre[1]) < PELVIS
        clearance = np.where(same, np.minimum(clearance, away), clearance)
    ground = replace(mesh.ground, clearance=clearance)
    walkable = (mesh.pieces.owner >= 0) & (clearance >= mesh.agent.radius)
    if not walkable.any():
        raise PathError("Other characters leave no ground to walk on; move them apart.")
    walkable = islands.prune(ground, walkable, mesh.agent.step)
    pieces = rectangles.cover(ground, walkable)
    return replace(mesh, ground=ground, pieces=pieces, portals=rectangles.portals(ground, pieces))
