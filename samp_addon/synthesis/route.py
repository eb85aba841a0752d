"""The way a character follows: a polyline on the floor, and the sub-goals along it (section 3.3)."""

from __future__ import annotations

import numpy as np

from ..motion import ACTIONS, Goal

REACHED = 0.3  # metres at which a way-point counts as reached
NEAR_GOAL = 0.5  # metres from the goal within which a corner is no goal of its own
SAME_PLACE = 0.15  # corners closer than this to the end of the way are dropped
STOPPING = 0.8  # metres before the end of a walk at which standing still becomes the goal
SPEED_UP = 1.5  # m/s2 with which people set off
STANDS_AHEAD = 0.20
"""Metres from the seated pelvis forward to where it stood before: median 0.16 of the captured sits, 90 % 0.22."""


class Route:
    """Way-points on the floor (N, 3) from the start to the goal, and the goals (N, 11) they make.

    The way to a seat ends where a body stands before it sits down, the way to a bed beside it; end_yaw is the facing
    there, radians. A goal row is world position 3, direction 3, one-hot action 5. The last row is the action's own
    goal. radii (N,): how near a goal counts as reached; along (N,): how far along the way it lies; metres.
    """

    def __init__(self, start: np.ndarray, waypoints: np.ndarray, goal: Goal, action: str) -> None:
        corners = [np.asarray(p, dtype=np.float64) for p in waypoints]
        place, direction = np.asarray(goal.position, dtype=np.float64), np.asarray(goal.direction, np.float64)
        flat = lambda a, b: float(np.linalg.norm((a - b)[[0, 2]]))
        if corners and flat(corners[0], start) < REACHED:
            corners = corners[1:]
        on_floor = action not in ("sit", "lie")
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
        steps = np.diff(self.points[:, [0, 2]], axis=0)
        self.lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(steps, axis=-1))])
        self.goals, self.radii, self.along = self._goals(goal, action, on_floor)

    @property
    def length(self) -> float:
        """Metres from the start to the end of the way."""
        return float(self.lengths[-1])

    def _goals(self, goal: Goal, action: str, on_floor: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Goal rows, how near counts as reached, and how far along the way each lies."""
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
            # Nobody stands still from afar: the end of the way is first walked towards.
            rows.append(np.concatenate([place, goal.direction, gait]))
            radii.append(STOPPING)
            along.append(self.length)
        last = np.eye(5)[ACTIONS.index("idle" if on_floor else action)]
        rows.append(np.concatenate([place, goal.direction, last]))
        return np.array(rows), np.array([*radii, 0.0]), np.array([*along, self.length])

    def at(self, distance: np.ndarray) -> np.ndarray:
        """Points (..., 2) at distances along the way, clamped to its ends."""
        return np.stack([np.interp(distance, self.lengths, self.points[:, k]) for k in (0, 2)], -1)

    def heights(self, positions: np.ndarray) -> np.ndarray:
        """Floor heights (T,) under a root's floor positions (T, 2), in order of time: never searched backwards."""
        if np.ptp(self.points[:, 1]) < 1e-9:
            return np.full(len(positions), self.points[0, 1])
        reached, out = 0.0, []
        for p in positions:
            reached = self.project(p, reached)
            out.append(np.interp(reached, self.lengths, self.points[:, 1]))
        return np.array(out)

    def project(self, position: np.ndarray, behind: float, ahead: float = 1.0) -> float:
        """Distance along the way of the closest point to position (2,), from ``behind`` to ``ahead`` metres on."""
        grid = np.linspace(behind, min(behind + ahead, self.length), 21)
        return float(grid[np.argmin(np.linalg.norm(self.at(grid) - position, axis=-1))])
