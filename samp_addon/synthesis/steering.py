"""Keeping a rollout on its route: the future path that the network sees, and small turns of the whole body.

The network alone cuts corners and drifts; the path between the furniture forgives neither.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
import torch

from .rollout import FUTURE, Follow, Steer
from .route import Route

FOLLOW = 0.6  # share by which the far end of the predicted path is laid onto the route
LOOK_AHEAD = 0.7  # metres along the route to the point that the character is turned towards
MOST_TURN = np.radians(2.0)  # per frame
MOST_SHIFT = 0.006  # metres per frame
LAST_STEP = 0.5  # metres before the goal that belong to the network
SAMPLE_SECONDS = 1 / 6  # between samples of the future path
TURN_GAIN, SHIFT_GAIN = 0.06, 0.06
MOVING = 0.010  # metres per frame: slower characters turn by themselves


class OnRoute(Protocol):
    """What steering needs of a take: its route, metres travelled along it, the number of its present goal, and the
    speed in m/s that it shall not fall behind."""

    route: Route
    travelled: float
    number: int
    pace: float


def guides(takes: Sequence[OnRoute]) -> tuple[Follow, Steer]:
    """The two functions that Rollout.step takes."""
    return (lambda future, roots: follow(takes, future, roots)), Steering(takes)


def _free(take: OnRoute) -> bool:
    """Whether the take is on its last step, which belongs to the network and the goal's frame."""
    return take.number == len(take.route.goals) - 1 and take.route.length - take.travelled < LAST_STEP


def follow(takes: Sequence[OnRoute], future: torch.Tensor, roots: torch.Tensor) -> torch.Tensor:
    """Bends the predicted future paths (B, 6, 3) onto the routes, far ahead more than near, and lengthens those that
    fall behind the take's pace: left alone, a slow prediction makes the next one slower still."""
    path = future.numpy().astype(np.float64).copy()
    now = roots.numpy().astype(np.float64)
    share = FOLLOW * (np.arange(1, FUTURE + 1) / FUTURE)
    for k, take in enumerate(takes):
        if _free(take):
            continue
        steps = np.diff(np.concatenate([now[k : k + 1, :2], path[k, :, :2]]), axis=0)
        predicted = np.cumsum(np.linalg.norm(steps, axis=-1))
        behind = np.maximum(take.pace * SAMPLE_SECONDS * np.arange(1, FUTURE + 1) - predicted, 0.0)
        ahead = take.travelled + predicted + share * behind
        wanted = take.route.at(ahead)
        way = take.route.at(ahead + 0.2) - take.route.at(ahead - 0.05)
        turn = _wrapped(np.arctan2(way[:, 0], way[:, 1]) - path[k, :, 2])
        path[k, :, :2] += share[:, None] * (wanted - path[k, :, :2])
        path[k, :, 2] += share * turn
    return torch.as_tensor(path, dtype=torch.float32)


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
        error = _wrapped(np.arctan2(*(ahead - root[:2])) - np.arctan2(*step))
        vigour = min(1.0, speed / (3 * MOVING))
        turn = np.clip(TURN_GAIN * error, -MOST_TURN, MOST_TURN) * vigour
        aside = SHIFT_GAIN * (on_route - root[:2])
        length = float(np.linalg.norm(aside))
        return aside * min(1.0, MOST_SHIFT / max(length, 1e-9)) * vigour, float(turn)


def _wrapped(angle: np.ndarray | float) -> np.ndarray | float:
    return (angle + np.pi) % (2 * np.pi) - np.pi
