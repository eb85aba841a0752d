"""Navmeshes of scenes that were built a moment ago: takes and jobs in one scene walk on the same ground."""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np

from . import navmesh
from .navmesh import Agent, NavMesh

KEPT = 3
"""Navmeshes that are kept: for an upright and for a sideways body, and where one can sit down."""

LARGE = 500_000
"""Triangles of a scene from which on its navmesh is not kept, because its triangles are kept with it."""


@dataclass(frozen=True)
class _Known:
    """A navmesh, and what it was built of. cover: (N, 3), or None where it makes no difference."""

    mesh: NavMesh
    triangles: np.ndarray
    cover: np.ndarray | None


_known: list[_Known] = []
_lock = threading.Lock()


def shared(triangles: np.ndarray, agent: Agent, cover: np.ndarray) -> NavMesh:
    """Return navmesh.build of triangles (F, 3, 3) and points (N, 3) to cover; the same one for equal arguments.

    The points to cover make no difference to a scene that has a floor and is not too large.
    """
    with _lock:
        for known in _known:
            if (
                known.mesh.agent == agent
                and (known.cover is None or np.array_equal(known.cover, cover))
                and (known.triangles is triangles or np.array_equal(known.triangles, triangles))
            ):
                return known.mesh
    mesh = navmesh.build(triangles, agent, cover=cover)
    if len(triangles) > LARGE:
        return mesh
    whole = mesh.laid_ground is None and navmesh.fits(triangles)
    with _lock:
        _known[:] = [_Known(mesh, triangles, None if whole else cover), *_known[: KEPT - 1]]
    return mesh
