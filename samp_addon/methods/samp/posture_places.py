"""What lies around a goal for a rest: a back to lean on, armrests, a table. Network frame, metres."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from ...motion import Goal
from ...scene.distance import solids
from ...scene.geometry import in_box, spread_over_surface
from ...scene.navmesh.lattice import clip_to_box

REACH = 0.8
"""Metres around the pelvis in which the surfaces are looked at."""

DENSITY = 2500
"""Surface samples per square metre."""

LEAST_AREA = {"lean_back": 0.02, "hands_on_armrests": 0.008, "hands_on_table": 0.02, "half_sitting": 0.02}
"""Square metres of surface within a region that are enough to lean or lie on."""

HEADBOARD = ((-0.25, 0.2, -0.5), (0.25, 0.6, -0.35))
"""Where a headboard is that carries a half sitting back, as in REGIONS."""

STEP, FARTHEST = 0.05, 0.9
"""Metres in which, and up to which, a place on a bed is moved towards its headboard."""

REGIONS = {
    "lean_back": (((-0.2, 0.12, -0.34), (0.2, 0.55, -0.06)),),
    "hands_on_armrests": (((0.2, -0.08, -0.1), (0.46, 0.2, 0.26)), ((-0.46, -0.08, -0.1), (-0.2, 0.2, 0.26))),
    "hands_on_table": (((-0.18, -0.02, 0.2), (0.18, 0.32, 0.62)),),
    "half_sitting": (((-0.25, 0.12, -0.75), (0.25, 0.6, -0.2)),),
}
"""Lowest and highest corner of where the surfaces lie: left, up and forward of the pelvis at the goal."""

_FLAT = ("hands_on_armrests", "hands_on_table")
SIDES = ((0.02, 0.36), (-0.36, -0.02))
"""Metres to the left of the pelvis in which the tops of the table for the left and the right hand are looked for."""
WRISTS = 0.17
"""Metres aside of the pelvis at which wrists lie on a table."""
FROM_EDGE, NEAREST, ARMS_LENGTH = 0.07, 0.28, 0.50
"""Metres from the edge of a table to a wrist on it, and from the pelvis forward to a wrist, at least and at most."""
WRIST = 0.04
"""Metres from the top of a table up to the joint of a wrist."""
UPWARD = 0.7
"""Vertical part of the unit normal of a surface on which a hand lies."""


def suited(triangles: np.ndarray, goal: Goal, posture: Collection[str]) -> Goal:
    """Return the place for a posture that the artist asks for: to half sit, one at the headboard of a bed.

    A goal stays where it is if there is none. triangles: (F, 3, 3) of everything near it.
    """
    if "half_sitting" not in posture:
        return goal
    low, high = map(np.array, HEADBOARD)
    for metres in np.arange(0.0, FARTHEST + STEP / 2, STEP):
        moved = replace(goal, position=goal.position - metres * np.asarray(goal.direction, float))
        points, _, each = _surface(triangles, moved)
        if in_box(points, low, high).sum() * each >= LEAST_AREA["half_sitting"]:
            return moved
    return goal


def table(triangles: np.ndarray, goal: Goal) -> np.ndarray | None:
    """Return the places (2, 3) of the left and the right wrist on a table in front of a goal, or None.

    triangles: (F, 3, 3) of everything near it. The goal's direction is horizontal.
    """
    own, flat, each = _surface(triangles, goal)
    (low, high), ahead = REGIONS["hands_on_table"][0], np.asarray(goal.direction, float)
    left = np.cross([0.0, 1.0, 0.0], ahead)
    places = []
    for side, aside in zip(SIDES, (WRISTS, -WRISTS), strict=True):
        corners = np.array([(side[0], *low[1:]), (side[1], *high[1:])])
        top = own[in_box(own, *corners) & flat]
        if len(top) * each < LEAST_AREA["hands_on_table"]:
            return None
        forward = float(np.clip(np.percentile(top[:, 2], 2) + FROM_EDGE, NEAREST, ARMS_LENGTH))
        near = top[np.abs(top[:, 2] - forward) < FROM_EDGE]
        if not len(near):
            return None
        up = float(np.percentile(near[:, 1], 95)) + WRIST
        places.append(
            np.asarray(goal.position, float) + aside * left + up * np.array([0, 1, 0]) + forward * ahead
        )
    return np.array(places)


def around(triangles: np.ndarray, goal: Goal) -> tuple[str, ...]:
    """Return the postures for which there is a place at a goal; the names are the keys of REGIONS.

    triangles: (F, 3, 3) of everything near it. The goal's direction is horizontal.
    """
    own, flat, each = _surface(triangles, goal)
    found = []
    for name, boxes in REGIONS.items():
        on = [in_box(own, np.array(a), np.array(b)) & (flat | (name not in _FLAT)) for a, b in boxes]
        if max(flags.sum() * each for flags in on) >= LEAST_AREA[name]:
            found.append(name)
    return tuple(found)


def _surface(triangles: np.ndarray, goal: Goal) -> tuple[np.ndarray, np.ndarray, float]:
    """Return points (N, 3) on what is near a goal, left, up and forward of it, their flags (N,) of facing up, and the
    square metres of each."""
    centre = np.asarray(goal.position, float)
    low, high = centre - REACH, centre + REACH
    near = clip_to_box(solids.overlapping_box(triangles, low, high), low, high)
    if not len(near):
        return np.zeros((0, 3)), np.zeros(0, bool), 0.0
    normals = np.cross(near[:, 1] - near[:, 0], near[:, 2] - near[:, 0])
    area = np.linalg.norm(normals, axis=-1) / 2
    near, normals, area = near[area > 0], normals[area > 0], area[area > 0]
    if not len(near):
        return np.zeros((0, 3)), np.zeros(0, bool), 0.0
    count = int(np.clip(area.sum() * DENSITY, 200, 60_000))
    points, index = spread_over_surface(near, count, area)
    each = float(area.sum()) / count
    own = _in_body_frame(points - centre, np.asarray(goal.direction, float))
    flat = np.abs(normals[index, 1]) / (2 * area[index]) > UPWARD
    return own, flat, each


def _in_body_frame(away: np.ndarray, ahead: np.ndarray) -> np.ndarray:
    """Return vectors (N, 3) as left, up and forward of a horizontal direction (3,)."""
    left = np.cross([0.0, 1.0, 0.0], ahead)
    return np.stack([away @ left, away[:, 1], away @ ahead], -1)
