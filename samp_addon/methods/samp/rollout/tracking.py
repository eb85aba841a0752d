"""How far the takes of a batch have come on their routes, and which goal each has in force. One row for each take."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np

from ....motion import ACTIONS
from ..request import Request
from ..route import SPEED_UP, Route, Routes, together

FPS = 30
ARRIVED = 0.2  # metres from the goal
STILL = 0.25  # m/s of the pelvis: a seated body still shifts
SINKING = 0.06  # m/s of the pelvis' height: who still sinks or rises does not sit yet
SITTING = 0.6  # weight of the action from which it is under way
PACES = {
    "walk": 1.25,
    "run": 2.4,
    "sit": 1.15,
    "lie": 1.15,
}  # m/s on a free stretch; furniture is walked up to slowly
OWN_PACE = (0.85, 1.15)  # everybody has their own, and so has every take
SLOWEST = 0.45  # m/s that a character may average on its way before the take counts as stuck
GRACE = 10.0  # seconds on top, for turning, sitting down and settling
LYING_DOWN = 6.0  # seconds more to lie down
SEATED_PELVIS, STANDING_PELVIS = 0.65, 0.85  # metres over the floor
LOW_SEAT = 0.45  # metres: bodies on lower seats are only asked to come down as far
MOST_DRIVE = 0.7  # m/s that the planned speed may be ahead of the body's
RISING = 0.15  # share of the pace at which somebody sets off who still sits
RECLINED = 0.6  # cosine of the chest's slope from which a body counts as lying
BESIDE = 2.0  # seconds that somebody sits beside the goal before the take counts as stuck
PASSED = 0.05  # metres beyond a way-point


@dataclass(frozen=True)
class Seen:
    """What a frame shows of the takes: roots (B, 2) on the floor, pelvis (B, 3), speed and sinking (B,) m/s of the
    pelvis and of its height, weights (B, 5) of the actions, upright (B,) cosines between chest and vertical."""

    roots: np.ndarray
    pelvis: np.ndarray
    speed: np.ndarray
    sinking: np.ndarray
    weights: np.ndarray
    upright: np.ndarray


class UnderWay:
    """Takes on their routes.

    travelled: metres along each. drive: the speed that its plan sets out with, pace: the one that it is to reach, m/s.
    risen: how far it has stood up, 0 to 1. number: of its goal in force. held: frames that its action was held at the
    goal; beside: frames that it was held elsewhere. done_at: the frame in which it was held for long enough, or -1.
    limit: frames after which it is stuck.
    """

    def __init__(self, requests: Sequence[Request], routes: Sequence[Route]) -> None:
        self.routes = Routes(routes)
        self.all_goals, self.radii, self.along = (
            together([getattr(route, name) for route in routes]) for name in ("goals", "radii", "along")
        )
        self.last = np.array([len(route.goals) - 1 for route in routes])
        self.action = np.array([ACTIONS.index(request.action) for request in requests])
        own = [np.random.default_rng(request.seed).uniform(*OWN_PACE) for request in requests]
        self.pace = np.array(own) * [PACES.get(request.action, PACES["walk"]) for request in requests]
        hold = np.array([request.hold_seconds for request in requests])
        self.hold = np.maximum(1, np.round(hold * FPS)).astype(int)
        more = np.where(self.action == ACTIONS.index("lie"), LYING_DOWN, 0.0)
        seconds = self.routes.length / SLOWEST + GRACE + more + hold
        self.limit = np.round(seconds * FPS).astype(int)
        self.travelled, self.drive = np.zeros(len(routes)), np.zeros(len(routes))
        self.risen = np.ones(len(routes))
        self.number, self.held, self.beside = (np.zeros(len(routes), int) for _ in range(3))
        self.done_at = np.full(len(routes), -1)

    def __len__(self) -> int:
        return len(self.pace)

    def only(self, rows: np.ndarray) -> UnderWay:
        """Some of them."""
        part = copy(self)
        for name, values in vars(self).items():
            setattr(part, name, values.only(rows) if isinstance(values, Routes) else values[rows])
        return part

    def goals(self) -> np.ndarray:
        """The goals in force (B, 11)."""
        return self.all_goals[np.arange(len(self)), self.number]

    def over(self, frame: int) -> np.ndarray:
        """Flags (B,) of the takes that are done, or stuck, at a frame."""
        return (self.done_at >= 0) | (frame >= self.limit) | (self.beside >= BESIDE * FPS)

    def share(self) -> float:
        """How far the slowest of them is, 0 to 1."""
        ways = np.minimum(self.travelled / np.maximum(self.routes.length, 0.1), 1.0) * 0.7
        return float((ways + 0.3 * (self.held > 0)).min())

    def update(self, seen: Seen, frame: int) -> None:
        """Passes way-points, and counts the frames in which the action is being held at the goal."""
        self.travelled = self.routes.project(seen.roots, self.travelled)
        # A plan made afresh from standing still says "soon" in every frame, and nobody ever sets off: the wish to be
        # under way grows while the body lags behind it.
        self.drive = np.minimum(np.minimum(self.drive + SPEED_UP / FPS, seen.speed + MOST_DRIVE), self.pace)
        height = (seen.pelvis[:, 1] - SEATED_PELVIS) / (STANDING_PELVIS - SEATED_PELVIS)
        self.risen = np.clip(height, RISING, 1.0)
        self._pass(seen.roots)
        near, resting = self._settled(seen)
        self.held = self.held + (near & resting)
        # Who sits in the air in front of the seat would sit on there, or slide to it in the end.
        self.beside = self.beside + (~near & resting & (self.action == ACTIONS.index("sit")))
        done = (self.held >= self.hold) & (self.done_at < 0)
        self.done_at = np.where(done, frame, self.done_at)

    def _pass(self, roots: np.ndarray) -> None:
        """The next goals, where the present ones are reached or passed."""
        row = np.arange(len(self))
        for _ in range(int(self.last.max())):
            away = roots - self.all_goals[row, self.number][:, [0, 2]]
            reached = np.hypot(away[:, 0], away[:, 1]) <= self.radii[row, self.number]
            passed = self.travelled > self.along[row, self.number] + PASSED
            on = (reached | passed) & (self.number < self.last)
            if not on.any():
                return
            self.number = self.number + on

    def _settled(self, seen: Seen) -> tuple[np.ndarray, np.ndarray]:
        """Flags (B,) of those who are where they shall be in the end, and of those who do what they shall do there."""
        goal = self.goals()
        action = goal[:, 6:].argmax(1)
        away = seen.pelvis - goal[:, :3]
        idle = action == 0
        near = np.hypot(away[:, 0], away[:, 2]) < np.where(idle, 2.0, 1.5) * ARRIVED
        settled = (self.number == self.last) & (seen.speed < STILL)
        # Who hesitates in front of a seat is near and still as well: it is the height that tells.
        low = seen.pelvis[:, 1] < np.maximum(goal[:, 1], LOW_SEAT) + ARRIVED
        busy = seen.weights[np.arange(len(self)), action] > SITTING
        settled &= idle | (busy & low & (seen.sinking < SINKING))
        return near, settled & ((action != ACTIONS.index("lie")) | (seen.upright < RECLINED))
