"""Keeping a rollout on its route: the future path that the network sees, and small turns of the whole body.

The network alone cuts corners and drifts; the path between the furniture forgives neither. In training, too, it sees
a planned path until it is near the seat (training/motion/train.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
import torch

from ...models.state import FPS, SAMPLE_STRIDE
from ..easing import smoothstep
from ..frames import wrapped
from ..motion import ACTIONS
from .rollout import FUTURE, Follow, Steer
from .route import SPEED_UP, Route

FOLLOW = 0.85  # share of the planned path in the future path; the rest is the network's prediction
LOOK_AHEAD = 0.7  # metres along the route to the point that the character is turned towards
MOST_TURN = np.radians(2.0)  # per frame
MOST_SHIFT = 0.006  # metres per frame
LAST_STEP = {"sit": 0.3, "lie": 0.3}  # metres of the way to a seat that belong to the network
TURN_GAIN, SHIFT_GAIN = 0.06, 0.06
MOVING = 0.010  # metres per frame: slower characters turn by themselves
SLOW_DOWN = 1.0  # m/s2 at the end of the planned path
TURNING = np.radians(150.0)  # rad/s of the planned path's facing
RETURN = 0.6  # seconds in which the planned path comes back to the route from beside it
FACE_GOAL = 0.6  # metres before the end of the way over which a body turns to the facing that it has there
CORNER = 0.25  # metres of way before and after a place whose direction is the planned facing
_TIMES = np.arange(1, FUTURE + 1) * SAMPLE_STRIDE / FPS


class OnRoute(Protocol):
    """What steering needs of a take: its route, metres travelled along it, the speed that its plan sets out with
    and the one it is to reach, m/s, and how far it has stood up, 0 to 1."""

    route: Route
    travelled: float
    drive: float
    pace: float
    risen: float


def guides(takes: Sequence[OnRoute]) -> tuple[Follow, Steer]:
    """The two functions that Rollout.step takes."""
    return (lambda future, roots: follow(takes, future, roots)), Steering(takes)


def _free(take: OnRoute) -> bool:
    """Whether the take is on its last steps to a seat, which belong to the network and the goal's frame."""
    action = ACTIONS[int(np.argmax(take.route.goals[-1][6:]))]
    return take.route.length - take.travelled < LAST_STEP.get(action, -1.0)


def follow(takes: Sequence[OnRoute], future: torch.Tensor, roots: torch.Tensor) -> torch.Tensor:
    """Lays the predicted future paths (B, 6, 3) onto the ones planned from the roots (B, 3) along the routes."""
    path = future.numpy().astype(np.float64).copy()
    for k, take in enumerate(takes):
        if _free(take):
            continue
        planned = plan(take, roots[k].numpy().astype(np.float64))
        path[k, :, :2] += FOLLOW * (planned[:, :2] - path[k, :, :2])
        path[k, :, 2] += FOLLOW * wrapped(planned[:, 2] - path[k, :, 2])
    return torch.as_tensor(path, dtype=torch.float32)


def plan(take: OnRoute, root: np.ndarray) -> np.ndarray:
    """The path (6, 3) of the coming second along the route, at the take's pace, from a root (x, z, yaw)."""
    route = take.route
    heading = _facing(route, np.array([take.travelled]))[0]
    # Who faces away from the way turns before walking off.
    pace = take.pace * take.risen * max(0.15, float(np.cos(np.clip(wrapped(heading - root[2]), -1.5, 1.5))))
    ahead = take.travelled + _distances(take.drive, pace, max(route.length - take.travelled, 0.0))
    places = route.at(ahead) + (root[:2] - route.at(take.travelled)) * np.exp(-_TIMES / RETURN)[:, None]
    turns = wrapped(_facing(route, ahead) - root[2])
    return np.column_stack([places, root[2] + np.clip(turns, -TURNING * _TIMES, TURNING * _TIMES)])


def _distances(speed: float, pace: float, left: float) -> np.ndarray:
    """Metres (6,) walked at the times of the samples by who has ``speed`` now and stops after ``left`` metres."""
    gone, out, step = 0.0, [], SAMPLE_STRIDE / FPS
    for _ in range(FUTURE):
        stopping = np.sqrt(2 * SLOW_DOWN * max(left - gone, 0.0))
        speed += float(np.clip(min(pace, stopping) - speed, -2 * SLOW_DOWN * step, SPEED_UP * step))
        gone = min(gone + max(speed, 0.0) * step, left)
        out.append(gone)
    return np.array(out)


def _facing(route: Route, distance: np.ndarray) -> np.ndarray:
    """Yaw (N,) of the way at distances (N,) along it, round at corners; at its end, the facing there."""
    way = route.at(distance + CORNER) - route.at(distance - CORNER)
    yaw = np.arctan2(way[:, 0], way[:, 1])
    turned = smoothstep(1 - (route.length - distance) / FACE_GOAL)
    return yaw + turned * wrapped(route.end_yaw - yaw)


class Steering:
    """Small turns and shifts of walking bodies towards their routes; the foot lock makes up for them."""

    def __init__(self, takes: Sequence[OnRoute]) -> None:
        self.takes = takes
        self.before: np.ndarray | None = None

    def __call__(self, roots: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        now = roots.numpy().astype(np.float64)
        shift, turn = np.zeros((len(now), 2)), np.zeros(len(now))
        if self.before is not None:
            for k, take in enumerate(self.takes):
                shift[k], turn[k] = self._one(take, now[k], now[k, :2] - self.before[k])
        self.before = now[:, :2] + shift
        return torch.as_tensor(shift, dtype=torch.float32), torch.as_tensor(turn, dtype=torch.float32)

    def _one(self, take: OnRoute, root: np.ndarray, step: np.ndarray) -> tuple[np.ndarray, float]:
        speed = float(np.linalg.norm(step))
        if _free(take) or speed < MOVING:
            return np.zeros(2), 0.0
        on_route = take.route.at(np.array(take.travelled))
        ahead = take.route.at(np.array(take.travelled + LOOK_AHEAD))
        # Turn the way that the body goes, not the way that it faces: nobody walks exactly where they look.
        error = wrapped(np.arctan2(*(ahead - root[:2])) - np.arctan2(*step))
        vigour = min(1.0, speed / (3 * MOVING))
        turn = np.clip(TURN_GAIN * error, -MOST_TURN, MOST_TURN) * vigour
        aside = SHIFT_GAIN * (on_route - root[:2])
        length = float(np.linalg.norm(aside))
        return aside * min(1.0, MOST_SHIFT / max(length, 1e-9)) * vigour, float(turn)
