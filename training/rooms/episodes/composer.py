"""Compose one episode: walking along navmesh routes, standing, sitting, shifting, rising and lying.

An episode is a generator that requests walks, so that the walks of many episodes are generated in one batch.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from ....samp_addon.easing import smoothstep
from ....samp_addon.frames import wrap_angle
from ...mocap.clip_files import FPS
from ..uses.use import ON_FURNITURE, Use
from . import captured, route
from .bank import LABELS, POSE, Bank, flat_root, pose_of, turned_flat
from .blending import LEAD, Piece, from_bank
from .matching import Walk
from .scene import PlacedUse, Scene

SECONDS = (15.0, 38.0)
LONGEST = 40.0
PACES = (0.65, 1.25)  # m/s
HOLDS = (2.5, 7.5)  # seconds of sitting
STANDS = (1.5, 7.0)
USING = 0.56  # probability that a use of furniture is next
STAYING = 0.06  # probability of keeping a use without a captured rise
MOST_DEEP = (
    2  # number of episodes rejected for penetration of a piece after which the piece is no longer used
)
SHORTEST_WALK = 11  # frames
MEET = 75  # last frames of a walk in which the transition to a use is searched
MEET_PLACE, MEET_TURN = 0.16, 0.3  # metres and radians with the cost of one unit of pose distance
FARTHEST, WIDEST = 0.45, np.radians(55)
KEY_WEIGHTS = np.array([2.0, 2, 2, 1, 1, 0.5, 0.3, 0.3])
LYING = (4.0, 14.0)  # seconds of lying
SETTLING = 6  # frames at the beginning of a hold that are not repeated
LEAST_HOLD, PER_SECOND = 24, 0.1  # frames; cost (weighted metres) of a second between actual and wanted hold
FARTHEST_REST = 1.2  # largest distance (weighted metres) of poses at a join while at rest
RAMP = 50  # frames over which the end of a walk is warped onto the start of a use
IDLE = LABELS.index("idle")
PIECE_WEIGHT, USE_WEIGHT = 0.35, 0.08  # weights of a piece, and of a use, without frames as captured


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
    """Compose one episode in a scene."""

    def __init__(self, bank: Bank, scene: Scene, rng: np.random.Generator) -> None:
        self.bank, self.scene, self.rng = bank, scene, rng
        self.idles = np.flatnonzero((bank.labels == IDLE) & (bank.still > 60) & bank.upright)
        enter = [p for p in scene.placed_uses if p.use.down >= 0 and scene.too_deep[p.item] < MOST_DEEP]
        # Uses without a rise would end most episodes early.
        self.enter = [placed for placed in enter if self._rises(placed) or rng.random() < STAYING]
        self.pace = rng.uniform(*PACES)
        self.pieces: list[Piece] = []
        self.flat = np.zeros(3)  # x, z, yaw of the root at the current end
        self.pose = np.zeros(POSE)
        self.speed = 0.0

    def compose(self) -> EpisodeSteps:
        """Yield walk requests; return the pieces of the episode in order. Raise EpisodeFailed."""
        rng, target = self.rng, self.rng.uniform(*SECONDS) * FPS
        scene = self.scene
        seated = [s for s in scene.placed_uses if s.use.up_end >= 0 and scene.too_deep[s.item] < MOST_DEEP]
        if seated and rng.random() < 0.25:
            self._rise(_drawn(self.bank, scene, seated, rng), start=True)
        else:
            self._appear()
        while self._frames() < target:
            chance = rng.random()
            if self.enter and chance < USING:
                placed = _drawn(self.bank, scene, self.enter, rng)
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
        """Append a captured idle or gesture whose pose is close to the current one."""
        count = int(seconds * FPS)
        fits = self.idles[self.bank.still[self.idles] > min(count, 150)]
        fits = self.rng.choice(fits, min(len(fits), 1500), replace=False)
        gap = ((self.bank.pose[fits] - self.pose) ** 2).sum(1)
        frame = int(fits[gap.argsort()[self.rng.integers(4)]])
        count = min(count, int(self.bank.still[frame]))
        self._add_bank(frame, turned_flat(self.bank.flat[frame : frame + count], self.flat))

    def _walk_to(self, place: np.ndarray, yaw: float) -> Generator[Request, Walk, None]:
        walk = yield from self._walk(place, yaw)
        # A walk that does not arrive is cut at its closest frame.
        closest = int(np.linalg.norm(walk.flat[:, :2] - place, axis=-1).argmin())
        self._add_walk(walk, walk.flat if walk.arrived else walk.flat[: max(closest, SHORTEST_WALK) + 1])

    def _walk(self, place: np.ndarray, yaw: float) -> Generator[Request, Walk, Walk]:
        corners = self.scene.route(self.flat[:2], place)
        if corners is None:
            raise EpisodeFailed("no route")
        length = float(np.linalg.norm(np.diff(corners, axis=0), axis=-1).sum())
        pace = min(self.pace * self.rng.uniform(0.9, 1.1), 0.55 + 0.3 * length)
        return (yield Request(route.rounded(corners, yaw, pace), self.flat, self.pose, self.speed))

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
        walk = yield from self._walk(placed.flat[0, :2], float(placed.flat[0, 2]))
        frame, into = self._meeting(walk, placed)
        flat = _led_to(walk.flat[: frame + 1], placed.flat[into])
        self._add_walk(walk, flat)
        return self._seated(placed, into + 1)

    def _rises(self, placed: PlacedUse) -> list[PlacedUse]:
        """Return the rises at the place of a use that begin close to a pose of its hold."""
        return [
            up for up in self.scene.rises(placed) if rest_gap(self.scene, placed, up).min() < FARTHEST_REST
        ]

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

    def _seated(self, placed: PlacedUse, first: int) -> bool:
        """Append a use from a frame on, its hold and a rise; return whether the episode ends there."""
        rng, use = self.rng, placed.use
        hold = int(rng.uniform(*(HOLDS if use.action == "sit" else LYING)) * FPS)
        if use.up_end >= 0 and abs(use.seat_end - use.seated - hold) < 60:
            self._add_use(placed, np.arange(first, len(use.labels)))
            return False
        ups = self._rises(placed)
        end, up, start = self._rest_join(placed, hold, ups) if ups else (use.seat_end, None, 0)
        self._add_use(placed, np.concatenate([np.arange(first, end + 1), there_and_back(use, end, hold)]))
        if up is None:
            return True
        self._add_use(up, np.arange(start, len(up.use.labels)))
        return False

    def _rest_join(self, placed: PlacedUse, hold: int, ups: list[PlacedUse]) -> tuple[int, PlacedUse, int]:
        """Return the frame in which a hold ends, the rise that follows and its first frame.

        The pair with the closest poses is chosen, since differences make feet slide; deviations from the wanted length
        of the hold add a cost.
        """
        early = np.abs(rest_ends(placed) - (placed.use.seated + hold)) / FPS * PER_SECOND
        best = (np.inf, 0, ups[0], LEAD)
        for up in ups:
            gap = rest_gap(self.scene, placed, up)
            cost = (gap + early[:, None] + np.where(gap < FARTHEST_REST, 0, 1e3)) * self.rng.uniform(1, 1.4)
            row, column = np.unravel_index(cost.argmin(), cost.shape)
            if cost[row, column] < best[0]:
                best = float(cost[row, column]), int(rest_ends(placed)[row]), up, LEAD + 3 * int(column)
        return best[1:]

    def _rise(self, placed: PlacedUse, start: bool = False) -> None:
        """Append a rise with some seconds of its hold; start: whether the episode begins with it."""
        use = placed.use
        held = use.seat_end - use.seated
        before = min(
            held - LEAD - 1, int(self.rng.uniform(*HOLDS) * FPS) if start else int(self.rng.integers(15, 75))
        )
        self._add_use(placed, np.arange(use.seat_end - max(before, 4), len(use.labels)))

    def _add_use(self, placed: PlacedUse, frames: np.ndarray) -> None:
        """Append frames (T,) of a use."""
        use = placed.use
        frames = frames[frames >= LEAD]
        if len(frames) < 4:
            return
        part = np.concatenate([frames[0] - LEAD + np.arange(LEAD), frames])
        self.pieces.append(
            Piece(
                placed.root[part], placed.rotations[part], use.labels[frames],
                use.feet[frames], use.source[frames], use.hands[frames],
                np.where(np.isin(use.labels[frames], ON_FURNITURE), placed.item, -1),
            )
        )  # fmt: skip
        end = frames[-12:]
        self.pose = pose_of(self.bank, placed.root[end], placed.rotations[end])[-1]
        self.flat = flat_root(placed.root[end], placed.rotations[end])[-1]
        last = frames[-1]
        self.speed = float(np.linalg.norm(placed.flat[last, :2] - placed.flat[last - 3, :2]) * FPS / 3)


def rest_ends(placed: PlacedUse) -> np.ndarray:
    """Return the frames (E,) of a hold after which a rise may follow."""
    use = placed.use
    return np.arange(min(use.seated + LEAST_HOLD, use.seat_end), use.seat_end + 1, 3)


def rest_gap(scene: Scene, placed: PlacedUse, up: PlacedUse) -> np.ndarray:
    """Return weighted distances (E, S), metres, from the poses of rest_ends to those of a rise's hold; cached.

    Every third pose of the rise's hold is compared.
    """
    key = id(placed), id(up)
    if key not in scene.gaps:
        starts = np.arange(LEAD, up.use.seat_end - 2, 3)
        away = placed.keys[rest_ends(placed)][:, None] - up.keys[starts]
        scene.gaps[key] = np.linalg.norm(away, axis=-1) @ KEY_WEIGHTS
    return scene.gaps[key]


def there_and_back(use: Use, end: int, hold: int) -> np.ndarray:
    """Return frames after ``end`` that repeat a short hold backwards and forwards up to the wanted length."""
    missing, length = use.seated + hold - end, end - use.seated - SETTLING
    if missing < 10 or length < 10:
        return np.zeros(0, int)
    turns = max(int(round(missing / (2 * length))), 1)
    back = np.arange(end - 1, end - length - 1, -1)
    return np.tile(np.concatenate([back, back[::-1][1:], [end]]), turns)


def _drawn(bank: Bank, scene: Scene, placed_uses: list[PlacedUse], rng: np.random.Generator) -> PlacedUse:
    """Draw a piece of furniture and a use of it, with probabilities that grow with the share as captured."""
    shares: dict[int, list[float]] = {}
    for placed in placed_uses:
        shares.setdefault(placed.item, []).append(captured.share(bank, scene, placed))
    pieces = sorted(shares)
    item = pieces[_weighted([PIECE_WEIGHT + max(shares[number]) for number in pieces], rng)]
    mine = [placed for placed in placed_uses if placed.item == item]
    return mine[_weighted([USE_WEIGHT + share for share in shares[item]], rng)]


def _weighted(weights: list[float], rng: np.random.Generator) -> int:
    """Draw an index with a probability proportional to its weight."""
    return int(rng.choice(len(weights), p=np.array(weights) / np.sum(weights)))


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
