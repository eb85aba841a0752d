"""Composition of one episode: walking along navmesh routes, standing, sitting, shifting, rising and lying.

An episode is a generator that requests walks, so that the walks of many episodes are generated in one batch.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from ....samp_addon import skeleton
from ....samp_addon.easing import smoothstep
from ....samp_addon.frames import wrap_angle
from ...mocap.clip_files import FPS
from . import route
from .bank import LABELS, POSE, Bank, flat_root, pose_of, turned_flat
from .blending import LEAD, Piece, from_bank
from .matching import Walk
from .scene import KEYS, PlacedUse, Scene

SECONDS = (15.0, 38.0)
LONGEST = 40.0
PACES = (0.65, 1.25)  # m/s
HOLDS = (2.5, 9.0)  # seconds of one stretch of sitting or lying
STANDS = (1.5, 7.0)
STAYING = 0.06  # probability of keeping a use from which nothing captured rises
MEET = 75  # last frames of a walk that are searched for the transition to a use
MEET_PLACE, MEET_TURN = 0.16, 0.3  # metres and radians that weigh as much as one unit of pose distance
FARTHEST, WIDEST = 0.45, np.radians(55)
KEY_WEIGHTS = np.array([2.0, 2, 2, 1, 1, 0.5, 0.3, 0.3])
FARTHEST_REST = 1.2  # weighted metres between poses at a join while at rest
RAMP = 50  # frames over which the end of a walk is warped onto the start of a use
IDLE, WALKING = LABELS.index("idle"), LABELS.index("walk")


class EpisodeFailed(Exception):  # noqa: N818
    """The episode cannot be composed; the message is the reason."""


@dataclass
class Request:
    """Arguments of matching.walk for one walker."""

    route: route.Route
    flat: np.ndarray
    pose: np.ndarray
    speed: float


EpisodeSteps = Generator[Request, Walk, list[Piece]]


class EpisodeComposer:
    """Composes one episode in a scene."""

    def __init__(self, bank: Bank, scene: Scene, rng: np.random.Generator) -> None:
        self.bank, self.scene, self.rng = bank, scene, rng
        self.idles = np.flatnonzero((bank.labels == IDLE) & (bank.still > 60))
        left = {placed.place for placed in scene.placed_uses if placed.use.up_end >= 0}
        enter = [placed for placed in scene.placed_uses if placed.use.down >= 0]
        # Places without a captured rise would end most episodes early.
        self.enter = [placed for placed in enter if placed.place in left or rng.random() < STAYING]
        self.pace = rng.uniform(*PACES)
        self.pieces: list[Piece] = []
        self.flat = np.zeros(3)  # x, z, yaw of the root at the present end
        self.pose = np.zeros(POSE)
        self.speed = 0.0

    def compose(self) -> EpisodeSteps:
        """Yield walk requests; return the pieces of the episode in order. Raise EpisodeFailed."""
        rng, target = self.rng, self.rng.uniform(*SECONDS) * FPS
        seated = [s for s in self.scene.placed_uses if s.use.up_end >= 0]
        if seated and rng.random() < 0.25:
            self._rise(_drawn(seated, rng), start=True)
        else:
            self._appear()
        while self._frames() < target:
            chance = rng.random()
            if self.enter and chance < 0.62:
                placed = _drawn(self.enter, rng)
                stays = yield from self._use(placed)
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
        """Start with a captured idle at a random place."""
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
        """Append a captured idle or gesture whose pose is close to the present one."""
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
            raise EpisodeFailed("no route")
        length = float(np.linalg.norm(np.diff(corners, axis=0), axis=-1).sum())
        pace = min(self.pace * self.rng.uniform(0.9, 1.1), 0.55 + 0.3 * length)
        walk = yield Request(route.rounded(corners, yaw, pace), self.flat, self.pose, self.speed)
        if not walk.arrived:
            raise EpisodeFailed("did not arrive")
        return walk

    def _add_walk(self, walk: Walk, flat: np.ndarray) -> None:
        at = 0
        for first, whole in walk.runs:
            count = min(whole, len(flat) - at)
            if count < 4:
                break
            self._add_bank(first, flat[at : at + count])
            at += count

    def _use(self, placed: PlacedUse) -> Generator[Request, Walk, bool]:
        """Walk to a use and append it; return whether the episode ends there."""
        use = placed.use
        walk = yield from self._walk(placed.flat[0, :2], float(placed.flat[0, 2]))
        frame, into = self._meeting(walk, placed)
        flat = _led_to(walk.flat[: frame + 1], placed.flat[into])
        self._add_walk(walk, flat)
        others = [s for s in self.scene.placed_uses if s.place == placed.place and s.use.action == use.action]
        return self._seated(placed, into + 1, others)

    def _meeting(self, walk: Walk, placed: PlacedUse) -> tuple[int, int]:
        """Return the frames of walk and use with the cheapest transition. Raise EpisodeFailed without one."""
        last = max(placed.use.down - 6, 1)
        use_pose = pose_of(self.bank, placed.root[: last + 8], placed.rotations[: last + 8])[:last]
        source = np.concatenate([first + np.arange(count) for first, count in walk.runs])
        frames = np.arange(max(len(source) - MEET, min(15, len(source) - 1)), len(source))
        gap = ((self.bank.pose[source[frames]][:, None] - use_pose) ** 2).sum(-1)
        away = np.linalg.norm(walk.flat[frames, None, :2] - placed.flat[:last, :2], axis=-1)
        turn = np.abs(wrap_angle(walk.flat[frames, None, 2] - placed.flat[:last, 2]))
        cost = gap + (away / MEET_PLACE) ** 2 + (turn / MEET_TURN) ** 2
        cost = np.where((away < FARTHEST) & (turn < WIDEST), cost, np.inf)
        best = np.unravel_index(cost.argmin(), cost.shape)
        if not np.isfinite(cost[best]):
            raise EpisodeFailed("does not meet the seat")
        return int(frames[best[0]]), int(best[1])

    def _seated(self, placed: PlacedUse, first: int, others: list[PlacedUse]) -> bool:
        """Append a use from a frame on, holds at the same place and a rise; return whether the episode ends there."""
        rng, use = self.rng, placed.use
        hold = int(rng.uniform(*HOLDS) * FPS)
        end = min(use.seat_end, use.seated + hold)
        if use.up_end >= 0 and use.seat_end - use.seated <= hold + 60:
            self._add_use(placed, first, len(use.labels))
            return False
        self._add_use(placed, first, end + 1)
        holds = [s for s in others if s.use.down < 0 and s.use.up_end < 0]
        if holds and rng.random() < 0.6:
            more = _drawn(holds, rng)
            self._add_hold(more)
        ups = [s for s in others if s.use.up_end >= 0]
        if use.up_end >= 0:
            ups = [*ups, placed]
        if not ups:
            return True
        self._rise_on(ups)
        return False

    def _rise_on(self, ups: list[PlacedUse]) -> None:
        """Append one of some rises, from where its hold is closest to the present pose."""
        now = key_joints(self.pieces[-1])
        best = (np.inf, ups[0], LEAD)
        for placed in ups:
            first = np.arange(LEAD, max(placed.use.seat_end - 3, LEAD + 1), 3)
            gap = np.linalg.norm(placed.keys[first] - now, axis=-1)
            # Feet slide where they differ; the shortest remaining hold is taken where several are alike.
            cost = (gap * KEY_WEIGHTS).sum(1) * self.rng.uniform(1, 1.4)
            k = int(cost.argmin())
            best = min(best, (float(cost[k]), placed, int(first[k])), key=lambda b: b[0])
        cost, placed, first = best
        if cost > FARTHEST_REST:
            raise EpisodeFailed("no rise from this pose")
        self._add_use(placed, first, len(placed.use.labels))

    def _add_hold(self, placed: PlacedUse) -> None:
        count = len(placed.use.labels)
        want = min(int(self.rng.uniform(*HOLDS) * FPS), count - LEAD)
        first = LEAD + int(self.rng.integers(0, count - LEAD - want + 1))
        self._add_use(placed, first, first + want)

    def _rise(self, placed: PlacedUse, start: bool = False) -> None:
        """Append a rise with some seconds of its hold; ``start``: the episode begins with it."""
        use = placed.use
        held = use.seat_end - use.seated
        before = min(
            held - LEAD - 1, int(self.rng.uniform(*HOLDS) * FPS) if start else int(self.rng.integers(15, 75))
        )
        self._add_use(placed, use.seat_end - max(before, 4), len(use.labels))

    def _add_use(self, placed: PlacedUse, first: int, stop: int) -> None:
        use = placed.use
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
                placed.root[part], placed.rotations[part], use.labels[own],
                use.feet[own], use.source[own], use.hands[own],
                np.where(sits, placed.item, -1),
            )
        )  # fmt: skip
        end = slice(max(stop - 12, 0), stop)
        self.pose = pose_of(self.bank, placed.root[end], placed.rotations[end])[-1]
        self.flat = flat_root(placed.root[end], placed.rotations[end])[-1]
        self.speed = float(np.linalg.norm(placed.flat[stop - 1, :2] - placed.flat[stop - 4, :2]) * FPS / 3)


def key_joints(piece: Piece) -> np.ndarray:
    """Places (K, 3) of scene.KEYS in the last frame of a piece."""
    rest = skeleton.default_rest_joints()
    return skeleton.forward_kinematics(piece.root[-1:], piece.rotations[-1:], rest)[0][0, KEYS]


def _drawn(placed_uses: list[PlacedUse], rng: np.random.Generator) -> PlacedUse:
    """Draw a use; every piece of furniture has the same probability."""
    items = sorted({placed.item for placed in placed_uses})
    item = items[rng.integers(len(items))]
    mine = [placed for placed in placed_uses if placed.item == item]
    return mine[rng.integers(len(mine))]


def _led_to(flat: np.ndarray, goal: np.ndarray) -> np.ndarray:
    """Warp the last RAMP frames of a trajectory (T, 3) so that it ends at a goal (3,)."""
    count = len(flat)
    share = (
        smoothstep((np.arange(count) - count + 1 + RAMP) / RAMP)
        if count > RAMP
        else smoothstep(np.linspace(0, 1, count))
    )
    off = goal - flat[-1]
    off[2] = wrap_angle(off[2])
    return flat + share[:, None] * off
