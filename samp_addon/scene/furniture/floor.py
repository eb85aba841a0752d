"""The floor beside a piece of furniture, from which the height of its seat is measured. Network frame, metres."""

from __future__ import annotations

import numpy as np

from ..geometry import extent
from ..navmesh import navmesh as navigation

BESIDE = 0.6
"""Metres around a target within which the ground is its floor."""

LEAST_RISE, ONE_STOREY = 0.05, 1.5
"""Metres: least height of a target over its floor, and largest difference of ground on one storey."""

STANDS = 0.12
"""Metres between the ground and the lowest point of an object that stands on it: feet are often left out."""


def floor_beside(mesh: navigation.NavMesh, target: np.ndarray) -> float | None:
    """Return the height of the ground beside an object, metres, or None where the object stands on it.

    target: (F, 3, 3) of the object, which may lie on a frame, hang, or be fixed to a wall.
    """
    low, high = extent(target)
    points = mesh.points
    near = ((points >= low - BESIDE) & (points <= high + BESIDE))[:, [0, 2]].all(axis=1)
    # The top of a bed can be walked on too.
    beside = near & ~((points >= low) & (points <= high))[:, [0, 2]].all(axis=1)
    below = points[beside & (points[:, 1] < high[1] - LEAST_RISE), 1]
    if not len(below):
        return None
    # Of several storeys, the one right below the object.
    below = below[below > below.max() - ONE_STOREY]
    floor = float(np.median(below))
    return None if abs(floor - low[1]) < STANDS else floor
