"""How far back a body can sit: people slide back until the rest, or the front edge at their shins, stops them."""

from __future__ import annotations

import numpy as np

from ... import frames
from ...motion import Goal
from . import postures, seats
from .probes import first_hit
from .support import SupportMap

STEP, FARTHEST = 0.02, 0.30  # metres
NEAREST = 0.14
"""Metres from the pelvis joint to a rest that the buttocks touch."""
SHINS = 0.03
"""Metres kept between the shins and the front edge."""
_RANGES = np.arange(0.06, 0.55, 0.02)


def slid_back(grid: SupportMap, goal: Goal, share: float = 1.0) -> Goal:
    """Return a goal to sit, moved back by a share of the way to where rest or shins stop it.

    A goal on a seat without a rest behind it is returned as it is.
    """
    at = grid.to_grid(np.asarray(goal.position, float))
    yaw = float(frames.direction_yaw(np.asarray(goal.direction))) - grid.yaw
    slides = np.arange(0.0, FARTHEST + SHINS + 1e-9, STEP)
    places = at - slides[:, None] * np.array([np.sin(yaw), np.cos(yaw)])
    yaws = np.full(len(places), yaw)
    height = postures.surface_height(grid, places)
    rest = np.median(
        [
            first_hit(grid, places[:1], yaws[:1], -_RANGES, x, height[:1] + 0.10, height[:1] + 0.42)
            for x in (-0.12, -0.05, 0.05, 0.12)
        ]
    )
    if not np.isfinite(height[0]) or rest > _RANGES[-2]:
        return goal
    fits = postures.sit_score(grid, places, yaws, height) > 0
    first = len(fits) if fits.all() else int(np.argmin(fits))
    most = min(slides[first - 1] - SHINS if first else 0.0, rest - NEAREST)
    if most < STEP:
        return goal
    moved = at - share * most * np.array([np.sin(yaw), np.cos(yaw)])
    level = float(postures.surface_height(grid, moved[None])[0])
    return seats.seat_at(grid, "sit", moved, yaw, level, 1.0).goal if np.isfinite(level) else goal
