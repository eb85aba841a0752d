"""Walking along given ways by motion matching: many walkers at once, every third of a second the captured frame whose
pose fits the present one and whose future fits the way ahead. Captured motion only; the way is met by small turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....samp_addon.frames import wrapped
from ...mocap import FPS
from .bank import AHEAD, Bank
from .search import Clearance, Search
from .way import STEP, Way

PLAY = 10  # frames that are played before the next search
GAIN, BRAKE = 1.6, 1.0  # m/s^2, of setting off and of coming to a stand
SPIN = 2.6  # rad/s, the quickest turn that is asked for
TURN_LIMIT, SHIFT_LIMIT = 0.14, 0.03  # radians, metres by which one piece is bent and moved towards the way
NEAR_END = 0.35  # metres before the end in which the body turns to its last facing
ARRIVED, STILL, FACED = 0.12, 0.25, np.radians(22)  # metres, m/s, radians
PATIENCE = 2.5  # seconds beyond those that the way takes at its pace


@dataclass
class Walk:
    """runs: (first bank frame, frames) of the captured pieces in a row. flat: (T, 3) x, z, yaw of each frame.
    arrived: whether the end of the way was reached."""

    runs: list[tuple[int, int]]
    flat: np.ndarray
    arrived: bool


class _Crowd:
    """The state of all walkers, in arrays (W, ...)."""

    def __init__(self, ways: list[Way], flat: np.ndarray, pose: np.ndarray, speed: np.ndarray) -> None:
        most = max(len(way.points) for way in ways)
        padded = lambda a: np.concatenate([a, np.repeat(a[-1:], most - len(a), axis=0)])
        self.points = np.stack([padded(way.points) for way in ways])
        self.tangent = np.stack([padded(way.tangent) for way in ways])
        self.length = np.array([way.length for way in ways])
        self.end_yaw = np.array([way.end_yaw for way in ways])
        self.pace = np.array([way.pace for way in ways])
        self.flat, self.pose, self.speed = flat.astype(float), pose.astype(np.float32), speed.astype(float)
        self.along = np.zeros(len(ways))
        self.frame = np.full(len(ways), -1)
        self.row = np.arange(len(ways))

    def place(self, along: np.ndarray) -> np.ndarray:
        """x and z (W, 2) at metres along the ways (W,)."""
        return self.points[self.row, self._at(along)]

    def direction(self, along: np.ndarray) -> np.ndarray:
        """Yaw (W,) along the ways; near their ends that of the end."""
        share = np.clip((along - self.length + NEAR_END) / NEAR_END, 0, 1)
        tangent = self.tangent[self.row, self._at(along)]
        return tangent + share * wrapped(self.end_yaw - tangent)

    def _at(self, along: np.ndarray) -> np.ndarray:
        return np.clip((along / STEP + 0.5).astype(int), 0, np.maximum(self.length / STEP, 0).astype(int))

    def progress(self) -> None:
        """How far along the nearest place of the way is, within the next metre."""
        steps = np.arange(-10, 50)
        at = np.clip(self._at(self.along)[:, None] + steps, 0, self.points.shape[1] - 1)
        gap = np.linalg.norm(self.points[self.row[:, None], at] - self.flat[:, None, :2], axis=-1)
        self.along = np.minimum(at[self.row, gap.argmin(1)] * STEP, self.length)

    def wanted(self) -> tuple[np.ndarray, np.ndarray]:
        """Places (W, 3, 2) in the root's frame and facings (W, 3) relative to it, at AHEAD frames."""
        along, speed, yaw = self.along.copy(), self.speed.copy(), self.flat[:, 2].copy()
        off = self.flat[:, :2] - self.place(self.along)
        places, facings, step = [], [], 5 / FPS
        for frame in range(5, AHEAD[-1] + 1, 5):
            astray = wrapped(self.direction(along + 0.15) - yaw)
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
        return local, wrapped(np.stack(facings, 1) - self.flat[:, 2:])


def walk(
    search: Search, ways: list[Way], flat: np.ndarray, pose: np.ndarray, speed: np.ndarray, rng: np.random.Generator,
    clearance: Clearance | None = None,
) -> list[Walk]:  # fmt: skip
    """A walk along each of some ways.

    flat: (W, 3) x, z, yaw at the start; pose: (W, 15) scaled pose features there; speed: (W,) m/s. clearance: metres
    to obstacles of places (..., 2). The first frame of a walk follows on the start.
    """
    bank = search.bank
    crowd = _Crowd(ways, flat, pose, speed)
    limit = np.array([way.length / max(way.pace, 0.3) * 1.6 + PATIENCE for way in ways]) * FPS
    pieces: list[list[tuple[int, int]]] = [[] for _ in ways]
    flats: list[list[np.ndarray]] = [[] for _ in ways]
    active, arrived, count = np.ones(len(ways), bool), np.zeros(len(ways), bool), np.zeros(len(ways))
    # Each has a taste of one's own for some clips.
    tastes = search.tastes(len(ways), rng)
    while active.any():
        places, facing = crowd.wanted()
        query = np.concatenate([crowd.pose, bank.way(places, facing)], -1).astype(np.float32)[active]
        found = search.frames(query, tastes[active], crowd.frame[active], crowd.flat[active], clearance, PLAY)
        moved = _played(bank, crowd, found, active)
        for k, w in enumerate(np.flatnonzero(active)):
            runs, first = pieces[w], int(found[k]) + 1
            if runs and runs[-1][0] + runs[-1][1] == first:
                runs[-1] = (runs[-1][0], runs[-1][1] + PLAY)
            else:
                runs.append((first, PLAY))
            flats[w].append(moved[k])
        count[active] += PLAY
        crowd.progress()
        there = np.linalg.norm(crowd.flat[:, :2] - crowd.place(crowd.length), axis=-1) < ARRIVED
        there &= np.abs(wrapped(crowd.end_yaw - crowd.flat[:, 2])) < FACED
        arrived |= active & there & (crowd.speed < STILL)
        active &= ~arrived & (count < limit)
    return [Walk(r, np.concatenate(f), bool(a)) for r, f, a in zip(pieces, flats, arrived, strict=True)]


def _played(bank: Bank, crowd: _Crowd, frames: np.ndarray, active: np.ndarray) -> np.ndarray:
    """Flat roots (A, PLAY, 3) of the pieces that follow on frames (A,), bent towards the way; the crowd moves on."""
    span = frames[:, None] + np.arange(PLAY + 1)
    source = bank.flat[span]
    steps = np.diff(source, axis=1)
    turn = crowd.flat[active, 2] - source[:, 0, 2]
    ramp = np.linspace(0, 1, PLAY + 1)[1:]
    straight = _integrated(crowd.flat[active], steps, turn[:, None] + 0 * ramp)
    # Where the piece would end, against where the way is.
    here = crowd.flat.copy()
    crowd.flat[active] = straight[:, -1]
    before = crowd.along.copy()
    crowd.progress()
    going = np.linalg.norm(straight[:, -1, :2] - here[active, :2], axis=-1) / PLAY * FPS
    ahead = crowd.place(crowd.along + 0.45) - crowd.flat[:, :2]
    far = (crowd.length - crowd.along > 0.5) & (np.linalg.norm(ahead, axis=-1) > 0.2)
    aim = np.where(far, np.arctan2(ahead[:, 0], ahead[:, 1]), crowd.direction(crowd.along))
    astray = wrapped(aim - crowd.flat[:, 2])[active]
    bend = np.clip(0.5 * astray, -TURN_LIMIT, TURN_LIMIT) * np.clip(going / 0.5, 0.15, 1)
    bent = _integrated(here[active], steps, turn[:, None] + bend[:, None] * ramp)
    bent[..., 2] += bend[:, None] * ramp
    off = (crowd.place(crowd.along) - crowd.flat[:, :2])[active] * 0.35
    size = np.linalg.norm(off, axis=-1, keepdims=True)
    off *= np.minimum(1, SHIFT_LIMIT * np.clip(going / 0.5, 0.2, 1)[:, None] / np.maximum(size, 1e-9))
    bent[..., :2] += off[:, None] * ramp[:, None]
    crowd.along = before
    crowd.flat[active] = bent[:, -1]
    crowd.frame[active] = span[:, -1]
    crowd.pose[active] = bank.pose[span[:, -1]]
    crowd.speed[active] = np.linalg.norm(bent[:, -1, :2] - bent[:, -4, :2], axis=-1) * FPS / 3
    return bent


def _integrated(start: np.ndarray, steps: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Flat roots (A, P, 3) from start (A, 3) by steps (A, P, 3), those turned by (A, P) radians."""
    c, s = np.cos(turn), np.sin(turn)
    moved = np.stack(
        [steps[..., 0] * c + steps[..., 1] * s, -steps[..., 0] * s + steps[..., 1] * c, steps[..., 2]], -1
    )
    return start[:, None] + np.cumsum(moved, axis=1)
