"""Progress of a batch of takes along their routes, and the goal in force of each. One row for each take."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np

from ....vocabulary import ACTIONS
from ..request import Request
from ..route import SPEED_UP, Route, Routes, pad_rows

FPS = 30
ARRIVED = 0.2  # metres from the goal
STILL = 0.25  # m/s of the pelvis: a seated body still shifts
SETTLED = 0.06  # m/s of the pelvis, vertical: faster bodies are still sitting down or rising
BUSY = 0.6  # weight of the action from which it is being performed
# m/s on a free stretch; furniture is approached slowly.
PACES = {"walk": 1.25, "run": 2.4, "sit": 1.15, "lie": 1.15}
PACE_RANGE = (0.85, 1.15)  # factor of the pace, drawn for each take as people differ
SLOWEST = 0.45  # m/s that a character must average along its route, else the take is stuck
GRACE = 10.0  # seconds added for turning, sitting down and settling
LYING_DOWN = 6.0  # seconds added for lying down
SEATED_PELVIS, STANDING_PELVIS = 0.65, 0.85  # metres over the floor
LOW_SEAT = 0.45  # metres of goal height: on lower seats the pelvis need not come down farther
MAX_LEAD = 0.7  # m/s that the planned speed may be ahead of the body's
RISING = 0.15  # share of the pace at which a seated body sets off
RECLINED = 0.6  # cosine between chest and vertical below which a body counts as lying
HALF_RECLINED = 0.9  # the same of one that rests half sitting, against a headboard or pillows
# Seconds after which a body that rests with its chest in the air counts as lying: finishing lays it down.
STAYS_RAISED = 1.5
MOTIONLESS = 0.06  # m/s of the pelvis of such a body
OFF_GOAL = 2.0  # seconds of sitting off the goal after which the take is stuck
PASSED = 0.05  # metres beyond a way-point
HESITANT, UPRIGHT = 0.4, 0.75  # m/s below which, and `rise` above which, a body on its feet hesitates
ON_THE_WAY = 0.8  # metres before the end of the route until which it should not


@dataclass(frozen=True)
class Observation:
    """Observation of one frame of B takes.

    roots: (B, 2) x and z, metres. pelvis: (B, 3) metres. speed, vertical_speed: (B,) of the pelvis, m/s. weights:
    (B, 5) of the actions. upright: (B,) cosine between chest and vertical.
    """

    roots: np.ndarray
    pelvis: np.ndarray
    speed: np.ndarray
    vertical_speed: np.ndarray
    weights: np.ndarray
    upright: np.ndarray


class RolloutProgress:
    """Progress of B takes along their routes; all arrays (B,).

    travelled: metres along the route. pace: speed to be reached, planned_speed: speed that the plan sets out with,
    m/s. rise: how far the body has stood up, 0 to 1. hesitated: seconds for which it has not set off. goal_index: of
    the goal in force. held: frames in which the action was held at the goal; held_off_goal: frames in which it was held
    elsewhere; raised: in which it rested on a bed with the chest in the air. hold: frames after which a held take is
    done; done_at: the frame in which it was, or -1. limit: frames after which a take is stuck. reclined: cosine between
    chest and vertical below which its body counts as lying.
    """

    def __init__(
        self, requests: Sequence[Request], routes: Sequence[Route], postures: Sequence[Sequence[str]] = ()
    ) -> None:
        """postures: of each take, see postures.py."""
        self.routes = Routes(routes)
        self.all_goals, self.radii, self.along = (
            pad_rows([getattr(route, name) for route in routes]) for name in ("goals", "radii", "along")
        )
        self.last = np.array([len(route.goals) - 1 for route in routes])
        self.action = np.array([ACTIONS.index(request.action) for request in requests])
        own = [np.random.default_rng(request.seed).uniform(*PACE_RANGE) for request in requests]
        self.pace = np.array(own) * [PACES.get(request.action, PACES["walk"]) for request in requests]
        hold = np.array([request.hold_seconds for request in requests])
        self.hold = np.maximum(1, np.round(hold * FPS)).astype(int)
        more = np.where(self.action == ACTIONS.index("lie"), LYING_DOWN, 0.0)
        seconds = self.routes.length / SLOWEST + GRACE + more + hold
        self.limit = np.round(seconds * FPS).astype(int)
        self.travelled, self.planned_speed = np.zeros(len(routes)), np.zeros(len(routes))
        self.rise, self.hesitated = np.ones(len(routes)), np.zeros(len(routes))
        self.goal_index, self.held, self.held_off_goal, self.raised = (
            np.zeros(len(routes), int) for _ in range(4)
        )
        self.done_at = np.full(len(routes), -1)
        half = ["half_sitting" in names for names in postures] or [False] * len(routes)
        self.reclined = np.where(half, HALF_RECLINED, RECLINED)

    def __len__(self) -> int:
        return len(self.pace)

    def select(self, rows: np.ndarray) -> RolloutProgress:
        """Return some of the takes."""
        part = copy(self)
        for name, values in vars(self).items():
            setattr(part, name, values.select(rows) if isinstance(values, Routes) else values[rows])
        return part

    def goals(self) -> np.ndarray:
        """Return the goals in force (B, 11), see Route."""
        return self.all_goals[np.arange(len(self)), self.goal_index]

    def ended(self, frame: int) -> np.ndarray:
        """Return flags (B,) of the takes that are done, or stuck, at a frame."""
        return (self.done_at >= 0) | (frame >= self.limit) | (self.held_off_goal >= OFF_GOAL * FPS)

    def share(self) -> float:
        """Return the progress of the slowest take, 0 to 1."""
        ways = np.minimum(self.travelled / np.maximum(self.routes.length, 0.1), 1.0) * 0.7
        return float((ways + 0.3 * (self.held > 0)).min())

    def update(self, seen: Observation, frame: int) -> None:
        """Advance along the routes to an observation, and count the frames in which the action is held."""
        self.travelled = self.routes.project(seen.roots, self.travelled)
        # A plan that is made afresh from standing still starts slowly in every frame, and the body never sets off: so
        # the planned speed grows while the body lags behind it.
        self.planned_speed = np.minimum(
            np.minimum(self.planned_speed + SPEED_UP / FPS, seen.speed + MAX_LEAD), self.pace
        )
        height = (seen.pelvis[:, 1] - SEATED_PELVIS) / (STANDING_PELVIS - SEATED_PELVIS)
        self.rise = np.clip(height, RISING, 1.0)
        waits = (seen.speed < HESITANT) & (self.rise > UPRIGHT)
        waits &= self.routes.length - self.travelled > ON_THE_WAY
        self.hesitated = np.where(waits, self.hesitated + 1 / FPS, 0.0)
        self._advance_goals(seen.roots)
        near, resting = self._arrived(seen)
        lies = self.action == ACTIONS.index("lie")
        still = near & resting & lies & (seen.upright >= self.reclined) & (seen.speed < MOTIONLESS)
        self.raised = np.where(still, self.raised + 1, 0)
        resting &= ~lies | (seen.upright < self.reclined) | (self.raised > STAYS_RAISED * FPS)
        self.held = self.held + (near & resting)
        # A body that sits in the air in front of its seat would stay there, or slide to the seat at the end.
        self.held_off_goal = self.held_off_goal + (~near & resting & (self.action == ACTIONS.index("sit")))
        done = (self.held >= self.hold) & (self.done_at < 0)
        self.done_at = np.where(done, frame, self.done_at)

    def _advance_goals(self, roots: np.ndarray) -> None:
        """Put the next goals in force where the present ones are reached or passed. roots: (B, 2)."""
        row = np.arange(len(self))
        for _ in range(int(self.last.max())):
            away = roots - self.all_goals[row, self.goal_index][:, [0, 2]]
            reached = np.hypot(away[:, 0], away[:, 1]) <= self.radii[row, self.goal_index]
            passed = self.travelled > self.along[row, self.goal_index] + PASSED
            on = (reached | passed) & (self.goal_index < self.last)
            if not on.any():
                return
            self.goal_index = self.goal_index + on

    def _arrived(self, seen: Observation) -> tuple[np.ndarray, np.ndarray]:
        """Return flags (B,) of the takes that are near their final goal, and of those that hold its action, or, if they
        are to lie, at least rest on the bed."""
        goal = self.goals()
        action = goal[:, 6:].argmax(1)
        away = seen.pelvis - goal[:, :3]
        idle = action == 0
        near = np.hypot(away[:, 0], away[:, 2]) < np.where(idle, 2.0, 1.5) * ARRIVED
        holds = (self.goal_index == self.last) & (seen.speed < STILL)
        # Distance and speed cannot tell standing from sitting; check pelvis height.
        low = seen.pelvis[:, 1] < np.maximum(goal[:, 1], LOW_SEAT) + ARRIVED
        busy = seen.weights[np.arange(len(self)), action] > BUSY
        return near, holds & (idle | (busy & low & (seen.vertical_speed < SETTLED)))
