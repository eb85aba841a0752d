"""One episode: a person walks about, stands, sits down, shifts, gets up, lies down, along ways of the navmesh.

An episode is a generator that asks for walks, so that the walks of many episodes are made at once.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from ....samp_addon.easing import smoothstep
from ....samp_addon.frames import wrapped
from ...mocap import FPS
from . import way
from .bank import LABELS, POSE, Bank, flat_root, pose_of, turned_flat
from .blending import LEAD, Piece, from_bank
from .matching import Walk
from .scene import Scene, Spot

SECONDS = (15.0, 38.0)
LONGEST = 40.0
PACES = (0.65, 1.25)  # m/s
HOLDS = (2.5, 9.0)  # seconds of one stretch of sitting or lying
STANDS = (1.5, 7.0)
STAYING = 0.06  # chance of each use that ends seated for good
MEET = 75  # last frames of a walk in which it may go over into a sit
MEET_PLACE, MEET_TURN = 0.16, 0.3  # metres and radians that count as much as one unit of the pose's distance
FARTHEST, WIDEST = 0.45, np.radians(55)
RAMP = 50  # frames over which a walk is moved to where the sit begins
IDLE, WALKING = LABELS.index("idle"), LABELS.index("walk")


class Stuck(Exception):  # noqa: N818
    """Why an episode could not be made."""


@dataclass
class Request:
    """A walk asked for: see matching.walk."""

    way: way.Way
    flat: np.ndarray
    pose: np.ndarray
    speed: float


Play = Generator[Request, Walk, list[Piece]]


class Player:
    """Makes episodes in one scene."""

    def __init__(self, bank: Bank, scene: Scene, rng: np.random.Generator) -> None:
        self.bank, self.scene, self.rng = bank, scene, rng
        self.idles = np.flatnonzero((bank.labels == IDLE) & (bank.still > 60))
        left = {spot.place for spot in scene.spots if spot.use.up_end >= 0}
        enter = [spot for spot in scene.spots if spot.use.down >= 0]
        # Mostly on places from which one can get up again.
        self.enter = [spot for spot in enter if spot.place in left or rng.random() < STAYING]
        self.pace = rng.uniform(*PACES)
        self.pieces: list[Piece] = []
        self.flat = np.zeros(3)  # where the person is, and faces
        self.pose = np.zeros(POSE)
        self.speed = 0.0

    def play(self) -> Play:
        """An episode as pieces in a row. Raises Stuck."""
        rng, target = self.rng, self.rng.uniform(*SECONDS) * FPS
        seated = [s for s in self.scene.spots if s.use.up_end >= 0]
        if seated and rng.random() < 0.25:
            self._rise(_drawn(seated, rng), start=True)
        else:
            self._appear()
        while self._frames() < target:
            chance = rng.random()
            if self.enter and chance < 0.62:
                spot = _drawn(self.enter, rng)
                stays = yield from self._use(spot)
                if stays:
                    break
            else:
                yield from self._walk_to(self.scene.place(rng), rng.uniform(-np.pi, np.pi))
                if rng.random() < 0.75:
                    self._stand(rng.uniform(*STANDS))
        return self.pieces

    def _frames(self) -> int:
        return sum(len(piece) for piece in self.pieces)

    def _appear(self) -> None:
        """Begins standing somewhere."""
        place = self.scene.place(self.rng)
        frame = int(self.rng.choice(self.idles))
        self.flat = np.array([*place, self.rng.uniform(-np.pi, np.pi)])
        self._add_bank(frame, turned_flat(self.bank.flat[frame : frame + 20], self.flat))

    def _add_bank(self, frame: int, flat: np.ndarray) -> None:
        self.pieces.append(from_bank(self.bank, frame, flat))
        last = frame + len(flat) - 1
        self.flat, self.pose = flat[-1].copy(), self.bank.pose[last]
        self.speed = float(np.linalg.norm(flat[-1, :2] - flat[-4, :2]) * FPS / 3)

    def _stand(self, seconds: float) -> None:
        """Stands or talks: a captured idle whose pose fits."""
        count = int(seconds * FPS)
        fits = self.idles[self.bank.still[self.idles] > min(count, 150)]
        fits = self.rng.choice(fits, min(len(fits), 1500), replace=False)
        gap = ((self.bank.pose[fits] - self.pose) ** 2).sum(1)
        frame = int(fits[gap.argsort()[self.rng.integers(4)]])
        count = min(count, int(self.bank.still[frame]))
        self._add_bank(frame, turned_flat(self.bank.flat[frame : frame + count], self.flat))

    def _walk_to(self, place: np.ndarray, yaw: float) -> Generator[Request, Walk, None]:
        walk = yield from self._walk(place, yaw)
        self._add_walk(walk, walk.flat)

    def _walk(self, place: np.ndarray, yaw: float) -> Generator[Request, Walk, Walk]:
        corners = self.scene.route(self.flat[:2], place)
        if corners is None:
            raise Stuck("no way")
        length = float(np.linalg.norm(np.diff(corners, axis=0), axis=-1).sum())
        pace = min(self.pace * self.rng.uniform(0.9, 1.1), 0.55 + 0.3 * length)
        walk = yield Request(way.rounded(corners, yaw, pace), self.flat, self.pose, self.speed)
        if not walk.arrived:
            raise Stuck("did not arrive")
        return walk

    def _add_walk(self, walk: Walk, flat: np.ndarray) -> None:
        at = 0
        for first, whole in walk.runs:
            count = min(whole, len(flat) - at)
            if count < 4:
                break
            self._add_bank(first, flat[at : at + count])
            at += count

    def _use(self, spot: Spot) -> Generator[Request, Walk, bool]:
        """Walks to a use and does it; returns whether the person stays there."""
        use = spot.use
        entry = max(0, use.down - 50)
        walk = yield from self._walk(spot.flat[entry, :2], float(spot.flat[entry, 2]))
        frame, into = self._meeting(walk, spot)
        flat = _led_to(walk.flat[: frame + 1], spot.flat[into])
        self._add_walk(walk, flat)
        others = [s for s in self.scene.spots if s.place == spot.place and s.use.action == use.action]
        return self._seated(spot, into + 1, others)

    def _meeting(self, walk: Walk, spot: Spot) -> tuple[int, int]:
        """Frame of the walk and frame of the use that follow on each other best. Raises Stuck."""
        last = max(spot.use.down - 6, 1)
        use_pose = pose_of(self.bank, spot.root[: last + 8], spot.rotations[: last + 8])[:last]
        source = np.concatenate([first + np.arange(count) for first, count in walk.runs])
        frames = np.arange(max(len(source) - MEET, min(15, len(source) - 1)), len(source))
        gap = ((self.bank.pose[source[frames]][:, None] - use_pose) ** 2).sum(-1)
        away = np.linalg.norm(walk.flat[frames, None, :2] - spot.flat[:last, :2], axis=-1)
        turn = np.abs(wrapped(walk.flat[frames, None, 2] - spot.flat[:last, 2]))
        cost = gap + (away / MEET_PLACE) ** 2 + (turn / MEET_TURN) ** 2
        cost = np.where((away < FARTHEST) & (turn < WIDEST), cost, np.inf)
        best = np.unravel_index(cost.argmin(), cost.shape)
        if not np.isfinite(cost[best]):
            raise Stuck("does not meet the seat")
        return int(frames[best[0]]), int(best[1])

    def _seated(self, spot: Spot, first: int, others: list[Spot]) -> bool:
        """The use from a frame on, other stretches in the same place, getting up; returns whether the person stays."""
        rng, use = self.rng, spot.use
        hold = int(rng.uniform(*HOLDS) * FPS)
        end = min(use.seat_end, use.seated + hold)
        if use.up_end >= 0 and use.seat_end - use.seated <= hold + 60:
            self._add_spot(spot, first, len(use.labels))
            return False
        self._add_spot(spot, first, end + 1)
        holds = [s for s in others if s.use.down < 0 and s.use.up_end < 0]
        if holds and rng.random() < 0.6:
            more = _drawn(holds, rng)
            self._add_hold(more)
        ups = [s for s in others if s.use.up_end >= 0]
        if use.up_end >= 0:
            ups = [*ups, spot]
        if not ups:
            return True
        self._rise(_drawn(ups, rng))
        return False

    def _add_hold(self, spot: Spot) -> None:
        count = len(spot.use.labels)
        want = min(int(self.rng.uniform(*HOLDS) * FPS), count - LEAD)
        first = LEAD + int(self.rng.integers(0, count - LEAD - want + 1))
        self._add_spot(spot, first, first + want)

    def _rise(self, spot: Spot, start: bool = False) -> None:
        """Getting up from a place, after some time if the episode starts there."""
        use = spot.use
        held = use.seat_end - use.seated
        before = min(
            held - LEAD - 1, int(self.rng.uniform(*HOLDS) * FPS) if start else int(self.rng.integers(15, 75))
        )
        self._add_spot(spot, use.seat_end - max(before, 4), len(use.labels))

    def _add_spot(self, spot: Spot, first: int, stop: int) -> None:
        use = spot.use
        first = max(first, LEAD)
        if stop - first < 4:
            return
        part = slice(first - LEAD, stop)
        own = slice(first, stop)
        sits = np.isin(
            use.labels[own],
            [LABELS.index(n) for n in ("sit_down", "sit", "stand_up", "lie_down", "lie", "get_up")],
        )
        self.pieces.append(
            Piece(
                spot.root[part], spot.rotations[part], use.labels[own], use.feet[own], use.source[own], use.hands[own],
                np.where(sits, spot.item, -1),
            )
        )  # fmt: skip
        end = slice(max(stop - 12, 0), stop)
        self.pose = pose_of(self.bank, spot.root[end], spot.rotations[end])[-1]
        self.flat = flat_root(spot.root[end], spot.rotations[end])[-1]
        self.speed = float(np.linalg.norm(spot.flat[stop - 1, :2] - spot.flat[stop - 4, :2]) * FPS / 3)


def _drawn(spots: list[Spot], rng: np.random.Generator) -> Spot:
    """A random spot, each piece of furniture as likely as another."""
    items = sorted({spot.item for spot in spots})
    item = items[rng.integers(len(items))]
    mine = [spot for spot in spots if spot.item == item]
    return mine[rng.integers(len(mine))]


def _led_to(flat: np.ndarray, goal: np.ndarray) -> np.ndarray:
    """A way (T, 3) whose end is moved to a goal (3,), more and more over its last frames."""
    count = len(flat)
    share = (
        smoothstep((np.arange(count) - count + 1 + RAMP) / RAMP)
        if count > RAMP
        else smoothstep(np.linspace(0, 1, count))
    )
    off = goal - flat[-1]
    off[2] = wrapped(off[2])
    return flat + share[:, None] * off
