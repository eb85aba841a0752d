"""Motion matching along given routes, for a batch of walkers.

Every PLAY frames, the captured frame with a similar pose and with a future along the route is searched. Only captured
motion is played; small turns and shifts keep it on the route.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....samp_addon.frames import wrap_angle
from ...mocap.clip_files import FPS
from .bank import AHEAD, Bank
from .route import STEP, Route
from .search import Clearance, Search

PLAY = 12  # frames played between two searches
GAIN, BRAKE = 1.6, 1.0  # acceleration and deceleration, m/s^2
SPIN = 2.6  # rad/s, largest turning rate of the desired trajectory
TURN_LIMIT, SHIFT_LIMIT = 0.14, 0.03  # largest turn (radians) and shift (m) of one piece towards the route
ENDING = 1.2  # distance (m) to the end below which other clips are preferred less reluctantly
NEAR_END = 0.35  # distance (m) to the end below which the body turns to its final facing
ARRIVED, STILL, FACED = 0.12, 0.25, np.radians(22)  # tolerances of arrival: metres, m/s, radians
PATIENCE = 2.5  # seconds allowed in addition to the route's expected duration


@dataclass
class Walk:
    """A walk.

    runs: (first bank frame, number of frames) of the captured pieces, in order. flat: (T, 3) x, z, yaw of each frame.
    arrived: whether the end of the route was reached.
    """

    runs: list[tuple[int, int]]
    flat: np.ndarray
    arrived: bool


class _Walkers:
    """The state of all walkers, in arrays (W, ...)."""

    def __init__(self, routes: list[Route], flat: np.ndarray, pose: np.ndarray, speed: np.ndarray) -> None:
        most = max(len(route.points) for route in routes)
        padded = lambda a: np.concatenate([a, np.repeat(a[-1:], most - len(a), axis=0)])
        self.points = np.stack([padded(route.points) for route in routes])
        self.tangent = np.stack([padded(route.tangent) for route in routes])
        self.length = np.array([route.length for route in routes])
        self.end_yaw = np.array([route.end_yaw for route in routes])
        self.pace = np.array([route.pace for route in routes])
        self.flat, self.pose, self.speed = flat.astype(float), pose.astype(np.float32), speed.astype(float)
        self.along = np.zeros(len(routes))
        self.frame = np.full(len(routes), -1)
        self.row = np.arange(len(routes))

    def place(self, along: np.ndarray) -> np.ndarray:
        """Return x and z (W, 2) at distances (W,), metres, along the routes."""
        return self.points[self.row, self._at(along)]

    def direction(self, along: np.ndarray) -> np.ndarray:
        """Return the yaw (W,) along the routes, blended into the final one near their ends."""
        share = np.clip((along - self.length + NEAR_END) / NEAR_END, 0, 1)
        tangent = self.tangent[self.row, self._at(along)]
        return tangent + share * wrap_angle(self.end_yaw - tangent)

    def _at(self, along: np.ndarray) -> np.ndarray:
        return np.clip((along / STEP + 0.5).astype(int), 0, np.maximum(self.length / STEP, 0).astype(int))

    def progress(self) -> None:
        """Update the distance along the routes to that of the nearest point, searched within the next metre."""
        steps = np.arange(-10, 50)
        at = np.clip(self._at(self.along)[:, None] + steps, 0, self.points.shape[1] - 1)
        gap = np.linalg.norm(self.points[self.row[:, None], at] - self.flat[:, None, :2], axis=-1)
        self.along = np.minimum(at[self.row, gap.argmin(1)] * STEP, self.length)

    def wanted(self) -> tuple[np.ndarray, np.ndarray]:
        """Return wanted positions (W, 3, 2) in the root's frame and relative facings (W, 3), at AHEAD frames."""
        along, speed, yaw = self.along.copy(), self.speed.copy(), self.flat[:, 2].copy()
        off = self.flat[:, :2] - self.place(self.along)
        places, facings, step = [], [], 5 / FPS
        for frame in range(5, AHEAD[-1] + 1, 5):
            astray = wrap_angle(self.direction(along + 0.15) - yaw)
            yaw = yaw + np.clip(astray, -SPIN * step, SPIN * step)
            most = np.sqrt(np.maximum(2 * BRAKE * (self.length - along), 0.0))
            target = np.minimum(self.pace * np.clip(np.cos(astray), 0.05, 1.0), most)
            speed = np.clip(target, speed - 2 * BRAKE * step, speed + GAIN * step)
            along = np.minimum(along + speed * step, self.length)
            if frame in AHEAD:
                places.append(self.place(along) + off * np.exp(-frame / FPS / 0.5))
                facings.append(yaw.copy())
        away = np.stack(places, 1) - self.flat[:, None, :2]
        c, s = np.cos(self.flat[:, 2])[:, None], np.sin(self.flat[:, 2])[:, None]
        local = np.stack([away[..., 0] * c - away[..., 1] * s, away[..., 0] * s + away[..., 1] * c], -1)
        return local, wrap_angle(np.stack(facings, 1) - self.flat[:, 2:])


def walk(
    search: Search, routes: list[Route], flat: np.ndarray, pose: np.ndarray, speed: np.ndarray,
    rng: np.random.Generator,
    clearance: Clearance | None = None,
) -> list[Walk]:  # fmt: skip
    """Return a walk along each route.

    flat: (W, 3) x, z, yaw at the start. pose: (W, 15) scaled pose features there. speed: (W,) m/s. clearance: function
    from positions (..., 2) to the distance from obstacles, metres. The first frame of a walk follows the start.
    """
    bank = search.bank
    walkers = _Walkers(routes, flat, pose, speed)
    limit = np.array([route.length / max(route.pace, 0.3) * 1.6 + PATIENCE for route in routes]) * FPS
    pieces: list[list[tuple[int, int]]] = [[] for _ in routes]
    flats: list[list[np.ndarray]] = [[] for _ in routes]
    active, arrived, count = np.ones(len(routes), bool), np.zeros(len(routes), bool), np.zeros(len(routes))
    # Weak random preferences for clips make walkers differ.
    preferences = search.preferences(len(routes), rng)
    while active.any():
        places, facing = walkers.wanted()
        query = np.concatenate([walkers.pose, bank.trajectory(places, facing)], -1).astype(np.float32)[active]
        found = search.frames(
            query, preferences[active], walkers.frame[active], walkers.flat[active], clearance, PLAY,
            (walkers.length - walkers.along < ENDING)[active],
        )  # fmt: skip
        moved = _played(bank, walkers, found, active)
        for k, w in enumerate(np.flatnonzero(active)):
            runs, first = pieces[w], int(found[k]) + 1
            if runs and runs[-1][0] + runs[-1][1] == first:
                runs[-1] = (runs[-1][0], runs[-1][1] + PLAY)
            else:
                runs.append((first, PLAY))
            flats[w].append(moved[k])
        count[active] += PLAY
        walkers.progress()
        there = np.linalg.norm(walkers.flat[:, :2] - walkers.place(walkers.length), axis=-1) < ARRIVED
        there &= np.abs(wrap_angle(walkers.end_yaw - walkers.flat[:, 2])) < FACED
        arrived |= active & there & (walkers.speed < STILL)
        active &= ~arrived & (count < limit)
    return [Walk(r, np.concatenate(f), bool(a)) for r, f, a in zip(pieces, flats, arrived, strict=True)]


def _played(bank: Bank, walkers: _Walkers, frames: np.ndarray, active: np.ndarray) -> np.ndarray:
    """Advance the walkers; return the flat roots (A, PLAY, 3) after frames (A,), bent towards the route."""
    span = frames[:, None] + np.arange(PLAY + 1)
    source = bank.flat[span]
    steps = np.diff(source, axis=1)
    turn = walkers.flat[active, 2] - source[:, 0, 2]
    ramp = np.linspace(0, 1, PLAY + 1)[1:]
    straight = _integrated(walkers.flat[active], steps, turn[:, None] + 0 * ramp)
    # Compare the end of the unchanged piece with the route.
    here = walkers.flat.copy()
    walkers.flat[active] = straight[:, -1]
    before = walkers.along.copy()
    walkers.progress()
    going = np.linalg.norm(straight[:, -1, :2] - here[active, :2], axis=-1) / PLAY * FPS
    ahead = walkers.place(walkers.along + 0.45) - walkers.flat[:, :2]
    far = (walkers.length - walkers.along > 0.5) & (np.linalg.norm(ahead, axis=-1) > 0.2)
    aim = np.where(far, np.arctan2(ahead[:, 0], ahead[:, 1]), walkers.direction(walkers.along))
    astray = wrap_angle(aim - walkers.flat[:, 2])[active]
    bend = np.clip(0.5 * astray, -TURN_LIMIT, TURN_LIMIT) * np.clip(going / 0.5, 0.15, 1)
    bent = _integrated(here[active], steps, turn[:, None] + bend[:, None] * ramp)
    bent[..., 2] += bend[:, None] * ramp
    off = (walkers.place(walkers.along) - walkers.flat[:, :2])[active] * 0.35
    size = np.linalg.norm(off, axis=-1, keepdims=True)
    off *= np.minimum(1, SHIFT_LIMIT * np.clip(going / 0.5, 0.2, 1)[:, None] / np.maximum(size, 1e-9))
    bent[..., :2] += off[:, None] * ramp[:, None]
    walkers.along = before
    walkers.flat[active] = bent[:, -1]
    walkers.frame[active] = span[:, -1]
    walkers.pose[active] = bank.pose[span[:, -1]]
    walkers.speed[active] = np.linalg.norm(bent[:, -1, :2] - bent[:, -4, :2], axis=-1) * FPS / 3
    return bent


def _integrated(start: np.ndarray, steps: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Return flat roots (A, P, 3) from start (A, 3) by steps (A, P, 3) turned by (A, P), radians."""
    c, s = np.cos(turn), np.sin(turn)
    moved = np.stack(
        [steps[..., 0] * c + steps[..., 1] * s, -steps[..., 0] * s + steps[..., 1] * c, steps[..., 2]], -1
    )
    return start[:, None] + np.cumsum(moved, axis=1)
