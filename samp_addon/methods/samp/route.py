"""The route of a character: a polyline on the floor, and the sub-goals along it (section 3.3)."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy

import numpy as np

from ...frames import ground_lengths
from ...motion import Goal
from ...vocabulary import ACTIONS, SEATED

REACHED = 0.3  # metres at which a way-point counts as reached
NEAR_GOAL = 0.5  # metres from the goal within which a corner is not a sub-goal
SAME_PLACE = 0.15  # metres from the end of the route within which corners are dropped
STOPPING = 0.8  # metres before the end of a walk at which the goal becomes to stand still
AHEAD = 1.0  # metres of the route, from the last known place on, that are searched for a body
SPEED_UP = 1.5  # m/s^2 at which people set off
STANDS_AHEAD = 0.20
"""Metres from the seated pelvis forward to where it stood before; in captured sits the median is 0.16, 90 % are below
0.22."""


class Route:
    """The route of one take; network frame, metres.

    points: (M, 3) on the floor, from the start to the end. goals: (N, 11), the sub-goals and, last, the goal: world
    position 3, direction 3, one-hot action 5. radii: (N,) within which a goal counts as reached. along: (N,) distance
    of each along the route. A route to a seat ends where a body stands before it sits down, one to a bed next to the
    bed; end_yaw is the facing there, radians.
    """

    def __init__(self, start: np.ndarray, waypoints: np.ndarray, goal: Goal, action: str) -> None:
        corners = [np.asarray(p, dtype=np.float64) for p in waypoints]
        place, direction = np.asarray(goal.position, dtype=np.float64), np.asarray(goal.direction, np.float64)
        flat = lambda a, b: float(np.linalg.norm((a - b)[[0, 2]]))
        if corners and flat(corners[0], start) < REACHED:
            corners = corners[1:]
        on_floor = action not in SEATED
        end, out = place, direction
        if action == "sit":
            end = place + STANDS_AHEAD * direction
        elif action == "lie" and corners:
            end = corners[-1]
            out = np.array([direction[2], 0.0, -direction[0]])
            out = out if (end - place) @ out > 0 else -out
        self.end_yaw = float(np.arctan2(out[0], out[2]))
        floor = float(corners[-1][1] if corners else start[1])
        corners = [p for p in corners if flat(p, end) >= (NEAR_GOAL if on_floor else SAME_PLACE)]
        points = [np.asarray(start, float), *corners, np.array([end[0], floor, end[2]])]
        keep = [0] + [k for k in range(1, len(points)) if flat(points[k], points[k - 1]) > 1e-3]
        self.points = np.array([points[k] for k in keep])
        if len(self.points) == 1:
            self.points = np.repeat(self.points, 2, 0)
        self.lengths = ground_lengths(self.points)
        self.goals, self.radii, self.along = self._goals(goal, action, on_floor)

    @property
    def length(self) -> float:
        """Return the metres from start to end."""
        return float(self.lengths[-1])

    def _goals(self, goal: Goal, action: str, on_floor: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return goals, radii and along."""
        gait = np.eye(5)[ACTIONS.index("run" if action == "run" else "walk")]
        rows, radii, along = [], [], []
        for k in range(1, len(self.points) - 1):
            if np.hypot(*(self.points[k] - goal.position)[[0, 2]]) < NEAR_GOAL:
                continue
            ahead = self.points[k + 1] - self.points[k - 1]
            facing = np.array([ahead[0], 0.0, ahead[2]]) / max(np.linalg.norm(ahead[[0, 2]]), 1e-9)
            rows.append(np.concatenate([[self.points[k][0], 0.0, self.points[k][2]], facing, gait]))
            radii.append(REACHED)
            along.append(self.lengths[k])
        height = 0.0 if on_floor else goal.position[1] - self.points[-1][1]
        place = np.array([goal.position[0], height, goal.position[2]])
        if on_floor and self.length > STOPPING:
            # Use a walk sub-goal until near; a distant idle goal stops too early.
            rows.append(np.concatenate([place, goal.direction, gait]))
            radii.append(STOPPING)
            along.append(self.length)
        last = np.eye(5)[ACTIONS.index("idle" if on_floor else action)]
        rows.append(np.concatenate([place, goal.direction, last]))
        return np.array(rows), np.array([*radii, 0.0]), np.array([*along, self.length])

    def heights(self, positions: np.ndarray, travelled: np.ndarray) -> np.ndarray:
        """Return the floor heights (T,) under floor positions (T, 2) of a root, in order of time.

        travelled: (T,) approximate metres along the route, which select the stretch where a route crosses itself.
        """
        if np.ptp(self.points[:, 1]) < 1e-9:
            return np.full(len(positions), self.points[0, 1])
        routes = Routes([self]).select(np.zeros(len(positions), int))
        along = routes.project(positions, np.maximum(travelled - AHEAD / 2, 0.0))
        return np.interp(np.maximum.accumulate(along), self.lengths, self.points[:, 1])


def pad_rows(rows: Sequence[np.ndarray]) -> np.ndarray:
    """Stack arrays (N, ...) of different lengths N as (B, max N, ...), repeating the last row of each."""
    count = max(len(values) for values in rows)
    return np.stack(
        [np.concatenate([values, np.repeat(values[-1:], count - len(values), 0)]) for values in rows]
    )


class Routes:
    """Several routes, queried as a batch.

    points: (B, N, 2), x and z. lengths: (B, N) along the route. length, end_yaw: (B,), see Route.
    """

    def __init__(self, routes: Sequence[Route]) -> None:
        self.points = pad_rows([route.points[:, [0, 2]] for route in routes])
        self.lengths = pad_rows([route.lengths for route in routes])
        self.length = self.lengths[:, -1]
        self.end_yaw = np.array([route.end_yaw for route in routes])
        self._legs = np.diff(self.points, axis=1)
        self._sizes = np.maximum(np.diff(self.lengths, axis=1), 1e-9)

    def select(self, rows: np.ndarray) -> Routes:
        """Return some of the routes."""
        part = copy(self)
        for name, values in vars(self).items():
            setattr(part, name, values[rows])
        return part

    def at(self, distance: np.ndarray) -> np.ndarray:
        """Return the points (B, K, 2) at distances (B, K) along the routes, clamped to their ends."""
        row = np.arange(len(distance))[:, None]
        leg = (distance[..., None] >= self.lengths[:, None, 1:-1]).sum(-1)
        share = (distance - self.lengths[row, leg]) / self._sizes[row, leg]
        return self.points[row, leg] + np.clip(share, 0, 1)[..., None] * self._legs[row, leg]

    def project(self, positions: np.ndarray, behind: np.ndarray) -> np.ndarray:
        """Return the distances (B,) along the routes of their closest points to positions (B, 2).

        The stretches from ``behind`` (B,) to AHEAD metres farther are searched.
        """
        begin, sizes = self.lengths[:, :-1], self._sizes
        first = (behind[:, None] - begin) / sizes
        last = (np.minimum(behind + AHEAD, self.length)[:, None] - begin) / sizes
        away = positions[:, None] - self.points[:, :-1]
        share = (away * self._legs).sum(-1) / sizes**2
        share = np.clip(share, np.clip(first, 0, 1), np.clip(last, 0, 1))
        gap = np.square(away - share[..., None] * self._legs).sum(-1)
        gap[(first > 1) | (last < 0)] = np.inf
        best = gap.argmin(1)[:, None]
        along = np.take_along_axis(begin + share * sizes, best, 1)[:, 0]
        return np.maximum(along, behind)  # rounding
