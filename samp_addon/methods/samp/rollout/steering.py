"""Steering of a rollout along its route: the future path that the network sees, and small turns of the whole body.

The network alone cuts corners and drifts, and paths between furniture leave no room for either. In training, too, it
sees a planned path until it is near the seat (training/samp/motion_net/train.py).
"""

from __future__ import annotations

import numpy as np
import torch

from .....models.state import FPS, SAMPLE_STRIDE
from ....easing import smoothstep
from ....frames import wrap_angle
from ....vocabulary import ACTIONS, SEATED
from ..route import SPEED_UP, Routes
from .rollout import FUTURE
from .tracking import RolloutProgress

FOLLOW = 0.85  # share of the planned path in the future path; the rest is the network's prediction
LOOK_AHEAD = 0.7  # metres along the route to the point that bodies are turned towards
MAX_TURN = np.radians(2.0)  # per frame
MAX_SHIFT = 0.006  # metres per frame
# Metres at the end of the route that are left to the network. As in training, it leads the turn in front of a seat;
# steered through it, bodies slide on both feet and the error of their final facing is twice as large.
LAST_STEP = {"sit": 0.75, "lie": 0.3}
OVERSHOT = 0.85  # metres from the end of the route beyond which they no longer are
STANDING = 0.75  # of RolloutProgress.rise, above which a body stands
TURN_GAIN, SHIFT_GAIN = 0.06, 0.06
MOVING = 0.010  # metres per frame below which bodies are not steered: they turn by themselves
SLOW_DOWN = 1.0  # m/s^2 at the end of the planned path
# The same where the goal is a seat or a bed. Captured people slow down from 0.9 to 0.4 m/s within 0.5 m.
SLOW_DOWN_TO_SEAT = 0.7
# Planned turns are as fast as those of people who turn on the spot: a body that sees faster ones slides on both feet.
TURNING = np.radians(110.0)  # rad/s of the planned facing
# Share of the pace that is planned for bodies that face away from their route, which turn before they set off. Now and
# then the network does not turn and drifts backwards for up to 7 s: so the share grows by IMPATIENCE per second that a
# body hesitates for longer than PATIENCE. A large share from the beginning makes bodies glide while they turn.
WILLING, MOST_WILLING = 0.15, 0.6
PATIENCE, IMPATIENCE = 1.5, 0.3
RETURN = 0.6  # seconds, time constant with which the planned path returns to the route
FACE_GOAL = 0.6  # metres before the end of the route over which the planned facing turns to the final one
CORNER = 0.25  # metres before and after a point of the route, between which its direction is measured
_SLOW_DOWN = np.array([SLOW_DOWN_TO_SEAT if action in SEATED else SLOW_DOWN for action in ACTIONS])
_LAST_STEPS = np.array([LAST_STEP.get(action, -1.0) for action in ACTIONS])
_TIMES = np.arange(1, FUTURE + 1) * SAMPLE_STRIDE / FPS


class Guide:
    """Guide of a rollout: sets the future path that the network sees, and turns and shifts walking bodies slightly
    towards their routes; the foot lock removes the foot slide that this causes.

    before: (B, 2) places of the roots in the previous frame, or None in the first.
    """

    def __init__(self, tracked: RolloutProgress) -> None:
        self.tracked = tracked
        self.before: np.ndarray | None = None

    def select(self, rows: np.ndarray, tracked: RolloutProgress) -> Guide:
        """Return the guide of some of the takes. tracked: their progress."""
        part = Guide(tracked)
        part.before = None if self.before is None else self.before[rows]
        return part

    def follow(self, future: torch.Tensor, roots: torch.Tensor) -> torch.Tensor:
        """Blend predicted future paths (B, 6, 3) with those planned from the roots (B, 3) along the routes."""
        path = future.numpy().astype(np.float64)
        roots = roots.numpy().astype(np.float64)
        planned = plan(self.tracked, roots)
        change = planned - path
        change[..., 2] = wrap_angle(change[..., 2])
        share = np.where(_is_free(self.tracked, roots), 0.0, FOLLOW)
        return torch.as_tensor(path + share[:, None, None] * change, dtype=torch.float32)

    def intend(self, future: torch.Tensor) -> torch.Tensor:
        """Once arrived, hold the target action: the network alone gets up now and then."""
        stays = torch.as_tensor(self.tracked.held > 0)
        wanted = torch.as_tensor(self.tracked.goals()[:, None, 6:], dtype=torch.float32)
        return torch.where(stays[:, None, None], wanted, future)

    def steer(self, roots: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return the shift (B, 2) and turn (B,) of the bodies at roots (B, 3)."""
        now = roots.numpy().astype(np.float64)
        shift, turn = np.zeros((len(now), 2)), np.zeros(len(now))
        if self.before is not None:
            shift, turn = self._correction(now, now[:, :2] - self.before)
        self.before = now[:, :2] + shift
        return torch.as_tensor(shift, dtype=torch.float32), torch.as_tensor(turn, dtype=torch.float32)

    def _correction(self, roots: np.ndarray, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return shift (B, 2) and turn (B,) of bodies at roots (B, 3) that moved by steps (B, 2) in the last frame."""
        tracked = self.tracked
        speed = np.hypot(steps[:, 0], steps[:, 1])
        places = tracked.routes.at(tracked.travelled[:, None] + np.array([0.0, LOOK_AHEAD]))
        aside, ahead = (places[:, k] - roots[:, :2] for k in (0, 1))
        # Correct the direction of travel, not the facing: people do not walk exactly where they face.
        error = wrap_angle(np.arctan2(ahead[:, 0], ahead[:, 1]) - np.arctan2(steps[:, 0], steps[:, 1]))
        vigour = np.minimum(1.0, speed / (3 * MOVING)) * ~(_is_free(tracked, roots) | (speed < MOVING))
        aside = SHIFT_GAIN * aside
        length = np.hypot(aside[:, 0], aside[:, 1])
        shift = aside * (np.minimum(1.0, MAX_SHIFT / np.maximum(length, 1e-9)) * vigour)[:, None]
        return shift, np.clip(TURN_GAIN * error, -MAX_TURN, MAX_TURN) * vigour


def _is_free(tracked: RolloutProgress, roots: np.ndarray) -> np.ndarray:
    """Return flags (B,) of the bodies on their last steps to a seat or bed, which are left to the network.

    Walkers that overshoot the seat are steered back. Beds are entered from farther away. roots: (B, 3).
    """
    away = roots[:, :2] - tracked.routes.points[:, -1]
    overshot = (np.hypot(away[:, 0], away[:, 1]) > OVERSHOT) & (tracked.rise > STANDING)
    overshot &= tracked.action == ACTIONS.index("sit")
    return (tracked.routes.length - tracked.travelled < _LAST_STEPS[tracked.action]) & ~overshot


def plan(tracked: RolloutProgress, roots: np.ndarray) -> np.ndarray:
    """Return the paths (B, 6, 3) of the coming second along the routes, at the takes' pace: x, z, yaw.

    roots: (B, 3), x, z, yaw.
    """
    routes, travelled = tracked.routes, tracked.travelled[:, None]
    facing = _facing(routes, travelled)[:, 0]
    least = np.clip(WILLING + IMPATIENCE * (tracked.hesitated - PATIENCE), WILLING, MOST_WILLING)
    willing = np.maximum(least, np.cos(np.clip(wrap_angle(facing - roots[:, 2]), -1.5, 1.5)))
    left = np.maximum(routes.length - tracked.travelled, 0.0)
    speed, pace = tracked.planned_speed * willing, tracked.pace * tracked.rise * willing
    ahead = travelled + _distances(speed, pace, left, _SLOW_DOWN[tracked.action])
    places = routes.at(np.concatenate([travelled, ahead], 1))
    aside = (roots[:, :2] - places[:, 0])[:, None] * np.exp(-_TIMES / RETURN)[:, None]
    turns = wrap_angle(_facing(routes, ahead) - roots[:, 2:])
    yaw = roots[:, 2:] + np.clip(turns, -TURNING * _TIMES, TURNING * _TIMES)
    return np.concatenate([places[:, 1:] + aside, yaw[..., None]], -1)


def _distances(speed: np.ndarray, pace: np.ndarray, left: np.ndarray, slow_down: np.ndarray) -> np.ndarray:
    """Return the metres (B, 6) walked at the times of the samples.

    speed: (B,) at present, pace: (B,) to be reached, m/s. left: (B,) metres to the stop. slow_down: (B,) m/s^2.
    """
    gone, out, step = np.zeros(len(speed)), [], SAMPLE_STRIDE / FPS
    for _ in range(FUTURE):
        stopping = np.sqrt(2 * slow_down * np.maximum(left - gone, 0.0))
        wanted = np.minimum(pace, stopping) - speed
        speed = speed + np.clip(wanted, -2 * slow_down * step, SPEED_UP * step)
        gone = np.minimum(gone + np.maximum(speed, 0.0) * step, left)
        out.append(gone)
    return np.stack(out, -1)


def _facing(routes: Routes, distance: np.ndarray) -> np.ndarray:
    """Return the planned yaws (B, K) at distances (B, K) along the routes: their direction, rounded at corners, turning
    to the final facing at the end."""
    places = routes.at(np.concatenate([distance + CORNER, distance - CORNER], 1))
    along = places[:, : distance.shape[1]] - places[:, distance.shape[1] :]
    yaw = np.arctan2(along[..., 0], along[..., 1])
    turned = smoothstep(1 - (routes.length[:, None] - distance) / FACE_GOAL)
    return yaw + turned * wrap_angle(routes.end_yaw[:, None] - yaw)
