"""Navmeshes that takes and jobs in one scene share."""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np

from . import navmesh
from .navmesh import Agent, NavMesh

KEPT = 3
"""Number of navmeshes that are kept: a job has up to three agents, see methods/scene_view.py."""

LARGE = 500_000
"""Triangles of a scene from which on its navmesh is not kept, because its triangles are kept with it."""


@dataclass(frozen=True)
class _Known:
    """A navmesh, and the arguments of its build. triangles: (F, 3, 3). cover: (N, 3), or None where the navmesh does
    not depend on it."""

    mesh: NavMesh
    triangles: np.ndarray
    cover: np.ndarray | None


_known: list[_Known] = []
_lock = threading.Lock()


def shared(triangles: np.ndarray, agent: Agent, cover: np.ndarray) -> NavMesh:
    """Return the navmesh of triangles (F, 3, 3), see navmesh.build; the same one for equal arguments.

    cover: (N, 3) points to cover; a scene that has a floor and fits into one grid does not depend on them. The
    triangles must not be changed in place.
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
