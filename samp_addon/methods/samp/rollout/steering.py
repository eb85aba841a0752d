"""Keeping a rollout on its route: the future path that the network sees, and small turns of the whole body.

The network alone cuts corners and drifts; the path between the furniture forgives neither. In training, too, it sees
a planned path until it is near the seat (training/samp/motion_net/train.py).
"""

from __future__ import annotations

import numpy as np
import torch

from .....models.state import FPS, SAMPLE_STRIDE
from ....easing import smoothstep
from ....frames import wrap_angle
from ....motion import ACTIONS
from ..route import SPEED_UP, Routes
from .rollout import FUTURE
from .tracking import UnderWay

FOLLOW = 0.85  # share of the planned path in the future path; the rest is the network's prediction
LOOK_AHEAD = 0.7  # metres along the route to the point that the character is turned towards
MOST_TURN = np.radians(2.0)  # per frame
MOST_SHIFT = 0.006  # metres per frame
LAST_STEP = {"sit": 0.3, "lie": 0.3}  # metres of the way to a seat that belong to the network
PAST = 0.35  # metres from the end of the way from which they no longer do
STANDING = 0.75  # share of the way up from which somebody stands
TURN_GAIN, SHIFT_GAIN = 0.06, 0.06
MOVING = 0.010  # metres per frame: slower characters turn by themselves
SLOW_DOWN = 1.0  # m/s2 at the end of the planned path
TURNING = np.radians(150.0)  # rad/s of the planned path's facing
RETURN = 0.6  # seconds in which the planned path comes back to the route from beside it
FACE_GOAL = 0.6  # metres before the end of the way over which a body turns to the facing that it has there
CORNER = 0.25  # metres of way before and after a place whose direction is the planned facing
_LAST_STEPS = np.array([LAST_STEP.get(action, -1.0) for action in ACTIONS])
_TIMES = np.arange(1, FUTURE + 1) * SAMPLE_STRIDE / FPS


class Guide:
    """What guides a rollout: the future path that it sees, and small turns and shifts of walking bodies towards their
    routes, which the foot lock makes up for."""

    def __init__(self, way: UnderWay) -> None:
        self.way = way
        self.before: np.ndarray | None = None

    def only(self, rows: np.ndarray, way: UnderWay) -> Guide:
        """Of some of the takes; way: theirs."""
        part = Guide(way)
        part.before = None if self.before is None else self.before[rows]
        return part

    def follow(self, future: torch.Tensor, roots: torch.Tensor) -> torch.Tensor:
        """Lays the predicted future paths (B, 6, 3) onto the ones planned from the roots (B, 3) along the routes."""
        path = future.numpy().astype(np.float64)
        roots = roots.numpy().astype(np.float64)
        planned = plan(self.way, roots)
        change = planned - path
        change[..., 2] = wrap_angle(change[..., 2])
        share = np.where(_free(self.way, roots), 0.0, FOLLOW)
        return torch.as_tensor(path + share[:, None, None] * change, dtype=torch.float32)

    def intend(self, future: torch.Tensor) -> torch.Tensor:
        """Who is where they shall be goes on with what they do: the network, left to itself, gets up now and then."""
        stays = torch.as_tensor(self.way.held > 0)
        wanted = torch.as_tensor(self.way.goals()[:, None, 6:], dtype=torch.float32)
        return torch.where(stays[:, None, None], wanted, future)

    def steer(self, roots: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """By how much each body at roots (B, 3) is moved (B, 2) and turned (B,)."""
        now = roots.numpy().astype(np.float64)
        shift, turn = np.zeros((len(now), 2)), np.zeros(len(now))
        if self.before is not None:
            shift, turn = self._correction(now, now[:, :2] - self.before)
        self.before = now[:, :2] + shift
        return torch.as_tensor(shift, dtype=torch.float32), torch.as_tensor(turn, dtype=torch.float32)

    def _correction(self, roots: np.ndarray, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        way = self.way
        speed = np.hypot(steps[:, 0], steps[:, 1])
        places = way.routes.at(way.travelled[:, None] + np.array([0.0, LOOK_AHEAD]))
        aside, ahead = (places[:, k] - roots[:, :2] for k in (0, 1))
        # Turn the way that the body goes, not the way that it faces: nobody walks exactly where they look.
        error = wrap_angle(np.arctan2(ahead[:, 0], ahead[:, 1]) - np.arctan2(steps[:, 0], steps[:, 1]))
        vigour = np.minimum(1.0, speed / (3 * MOVING)) * ~(_free(way, roots) | (speed < MOVING))
        aside = SHIFT_GAIN * aside
        length = np.hypot(aside[:, 0], aside[:, 1])
        shift = aside * (np.minimum(1.0, MOST_SHIFT / np.maximum(length, 1e-9)) * vigour)[:, None]
        return shift, np.clip(TURN_GAIN * error, -MOST_TURN, MOST_TURN) * vigour


def _free(way: UnderWay, roots: np.ndarray) -> np.ndarray:
    """Flags (B,) of those on their last steps to a seat or bed, which belong to the network and the goal's frame; who
    walks past a seat, roots (B, 3), is led back while standing. Beds are got into from farther away."""
    away = roots[:, :2] - way.routes.points[:, -1]
    past = (np.hypot(away[:, 0], away[:, 1]) > PAST) & (way.risen > STANDING)
    past &= way.action == ACTIONS.index("sit")
    return (way.routes.length - way.travelled < _LAST_STEPS[way.action]) & ~past


def plan(way: UnderWay, roots: np.ndarray) -> np.ndarray:
    """The paths (B, 6, 3) of the coming second along the routes, at the takes' pace, from roots (B, 3): x, z, yaw."""
    routes, travelled = way.routes, way.travelled[:, None]
    facing = _facing(routes, travelled)[:, 0]
    # Who faces away from the way turns before walking off.
    willing = np.maximum(0.15, np.cos(np.clip(wrap_angle(facing - roots[:, 2]), -1.5, 1.5)))
    left = np.maximum(routes.length - way.travelled, 0.0)
    ahead = travelled + _distances(way.drive, way.pace * way.risen * willing, left)
    places = routes.at(np.concatenate([travelled, ahead], 1))
    beside = (roots[:, :2] - places[:, 0])[:, None] * np.exp(-_TIMES / RETURN)[:, None]
    turns = wrap_angle(_facing(routes, ahead) - roots[:, 2:])
    yaw = roots[:, 2:] + np.clip(turns, -TURNING * _TIMES, TURNING * _TIMES)
    return np.concatenate([places[:, 1:] + beside, yaw[..., None]], -1)


def _distances(speed: np.ndarray, pace: np.ndarray, left: np.ndarray) -> np.ndarray:
    """Metres (B, 6) walked at the times of the samples by who have ``speed`` now and stop after ``left`` metres."""
    gone, out, step = np.zeros(len(speed)), [], SAMPLE_STRIDE / FPS
    for _ in range(FUTURE):
        stopping = np.sqrt(2 * SLOW_DOWN * np.maximum(left - gone, 0.0))
        wanted = np.minimum(pace, stopping) - speed
        speed = speed + np.clip(wanted, -2 * SLOW_DOWN * step, SPEED_UP * step)
        gone = np.minimum(gone + np.maximum(speed, 0.0) * step, left)
        out.append(gone)
    return np.stack(out, -1)


def _facing(routes: Routes, distance: np.ndarray) -> np.ndarray:
    """Yaws (B, K) of the ways at distances (B, K) along them, round at corners; at their ends, the facings there."""
    places = routes.at(np.concatenate([distance + CORNER, distance - CORNER], 1))
    way = places[:, : distance.shape[1]] - places[:, distance.shape[1] :]
    yaw = np.arctan2(way[..., 0], way[..., 1])
    turned = smoothstep(1 - (routes.length[:, None] - distance) / FACE_GOAL)
    return yaw + turned * wrap_angle(routes.end_yaw[:, None] - yaw)
