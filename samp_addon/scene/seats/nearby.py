"""Places to sit or lie near a point of a piece of furniture, for what is under a mouse: a few of them, at once.

The search of seats.py is that of a whole piece, which takes seconds. Network frame, metres, radians.
"""

from __future__ import annotations

import numpy as np

from ... import frames
from ...motion import Goal
from . import postures, seats
from .support import SupportMap

REACH, STEP = 0.3, 0.075
"""Metres around a point in which places are looked for, and between them."""

DIRECTIONS = 12

AWAY = 0.4
"""Score that the farthest place in reach loses against one at the point itself."""

TURNED = np.radians(60)
"""Least difference between the facings of two places that are offered for one point."""

LEAST = {"sit": 0.2, "lie": 0.3}
"""Least score of a place that is offered."""


def places(grid: SupportMap, point: np.ndarray, action: str, yaw: float | None = None) -> list[seats.Seat]:
    """Return the places for an action within reach of a point (3,), best first, each of another facing.

    yaw: of the only facing that is wanted.
    """
    step = np.arange(-REACH, REACH + 1e-9, STEP)
    x, z = (values.ravel() for values in np.meshgrid(step, step, indexing="ij"))
    offset = np.stack([x, z], -1)[np.hypot(x, z) <= REACH + 1e-9]
    turns = np.arange(DIRECTIONS) * 2 * np.pi / DIRECTIONS if yaw is None else np.array([yaw - grid.yaw])
    at = grid.to_grid(point) + offset
    level = postures.surface_height(grid, at)
    known = np.isfinite(level)
    at, level, away = at[known], level[known], np.hypot(*offset[known].T) / REACH
    count = len(turns)
    where, yaws, height = np.repeat(at, count, 0), np.tile(turns, len(at)), np.repeat(level, count)
    score = seats.score_at(grid, action, where, yaws, height)
    value = np.where(score >= LEAST[action], score - AWAY * np.repeat(away, count) ** 2, -np.inf)
    found: list[seats.Seat] = []
    while len(value) and np.isfinite(value).any():
        best = int(value.argmax())
        found.append(seats.seat_at(grid, action, where[best], yaws[best], height[best], score[best]))
        value[np.abs(frames.wrap_angle(yaws - yaws[best])) < TURNED] = -np.inf
    return found


def surface(grid: SupportMap, point: np.ndarray) -> float:
    """Return the height over the floor of the surface that carries a body at a point (3,), NaN where none does."""
    return float(postures.surface_height(grid, grid.to_grid(point)[None])[0])


def goal_at(point: np.ndarray, yaw: float, action: str) -> Goal:
    """Return the goal of a body on the surface at a point (3,)."""
    lift = postures.SEAT_TO_PELVIS if action == "sit" else postures.BED_TO_PELVIS
    return Goal(np.asarray(point, float) + [0.0, lift, 0.0], frames.yaw_direction(yaw), action)


def on_surface(goal: Goal) -> np.ndarray:
    """Return the point (3,) of the surface below a goal; the inverse of `goal_at`."""
    lift = postures.SEAT_TO_PELVIS if goal.action == "sit" else postures.BED_TO_PELVIS
    return np.asarray(goal.position) - [0.0, lift, 0.0]
