"""Sit sequences fitted to their seats: captured sits on many pieces each, with prepended walks."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import numpy as np

from ...samp_addon import rotation
from ...samp_addon.easing import smoothstep
from ...samp_addon.motion import Goal
from ...samp_addon.scene.seats.postures import SEAT_TO_PELVIS
from ..composition.checks import fault
from ..composition.sequence import Sequence
from ..composition.sits import SIDEWAYS, TURNS, Composer
from ..composition.stitch import WalkIndex
from ..composition.walks import by_way_point, way_points
from ..mocap.clip_files import Clip
from ..mocap.events import SitEvent, headings
from . import sit_fit
from .provenance import Owed, owed
from .shapes.pieces import FittingPiece
from .sit_fit import Fitted
from .spreading import Phases

MODES = {"leaning": 0.86, "upright": 0.10, "perching": 0.04}  # shares on pieces with a back
WITHOUT_BACK = {"upright": 0.85, "perching": 0.15}
LOOKED_AT = 40  # seats checked for one motion
TRIES = 5  # seats fitted, of those
BODY = 0.04  # least distance (m) of a walking pelvis from a piece
STANDS = 0.17  # least distance (m) of captured standing bodies in front of the seated pelvis
REACH = 0.15  # metres by which a captured seat and another may differ in height
WALKS = 3
BEFORE, AFTER = 24, 16  # frames before sitting down and after standing up of a trimmed sit
LED_IN = 24  # frames after a walk's end over which the relocked feet are blended in
IN_VAIN = 0.25  # usage that a failed try adds to a piece; a kept sit adds 1
NEAR = 0.08  # difference in height (m) at which the probability of a seat falls to a third
OTHER_PACE = 0.4  # share of the sits with a changed pace
SIDEWAYS_ON = ("bed", "pouf", "bench", "stool", "sofa", "l_sofa")


def trimmed(event: SitEvent) -> SitEvent:
    """Return the event with at most BEFORE frames before sitting down and AFTER frames after standing up.

    Captured walks may cross the place of a sofa, and episodes in rooms have walks of their own.
    """
    entry = max(event.entry, event.down - BEFORE)
    return replace(event, entry=entry, leave_end=min(event.leave_end, event.up_end + AFTER))


class FittedComposer:
    """Compose fitted sit sequences; report counts kept and dropped ones by reason."""

    def __init__(
        self, pieces: list[FittingPiece], walks: WalkIndex, seed: int, approaches: int = WALKS
    ) -> None:
        """Collect the seats of the pieces. approaches: walks to try before one sit, besides its own."""
        self.approaches = approaches
        self.rng = np.random.default_rng(seed)
        self.captured = Composer([], walks, seed)  # cuts, paces and walks of the captured sits
        self.report: Counter[str] = Counter()
        self.owed: list[Owed] = []
        self.fitted: list[Fitted] = []
        self.seats = [(piece, goal) for piece in pieces for goal in piece.seats]
        self.used: defaultdict[int, float] = defaultdict(float)
        places = Counter(piece.index for piece, _ in self.seats)
        self.chances = np.array([places[piece.index] ** -0.5 for piece, _ in self.seats])
        self.levels = np.array([goal.position[1] - SEAT_TO_PELVIS for _, goal in self.seats])

    def compose(self, event: SitEvent) -> list[Sequence]:
        """Return sequences of an event on the first seat that it fits: with its own approach, and with other walks."""
        clip, frames = self.captured._excerpt(event)
        if self.rng.random() < OTHER_PACE:
            clip, frames = self.captured._paced(clip, frames)
        phases = Phases(*(frames[name] for name in ("down", "seated", "seat_end", "up_end")))
        why = fault(clip)
        if why is not None:
            self.report[f"captured: {why}"] += 1
            return []
        for piece, goal, sideways in islice(self._free_seats(clip, phases), TRIES):
            made = self._on(piece, goal, sideways, clip, phases)
            if made is not None:
                place = piece.seat_surface(goal).frame.placement
                return [
                    self._sequence(variant, at, piece, place)
                    for variant, at in self._approached(made, phases, piece, goal)
                ]
        self.report["no seat fits"] += 1
        return []

    def _approached(
        self, made: Fitted, phases: Phases, piece: FittingPiece, goal: Goal
    ) -> Iterator[tuple[Fitted, Phases]]:
        """Yield the fitted sit, then the sit with other free walks prepended, each with its phases."""
        yield made, phases
        surface = piece.seat_surface(goal)
        frames = {name: getattr(phases, name) for name in ("down", "seated", "seat_end", "up_end")}
        for _ in range(self.approaches if phases.down > 12 else 0):
            clip, shifted = self.captured.approach(made.clip, dict(frames))
            shift = shifted["down"] - phases.down
            if clip is made.clip:
                continue
            clip = approach_alone(clip, made.clip, shift)
            later = Phases(*(shifted[name] for name in frames))
            try:
                sit_fit.free_way(clip, later, surface, piece.field, later.seated)
                why = fault(clip)
                if why is not None:
                    raise sit_fit.Unfit(why)
            except sit_fit.Unfit as unfit:
                self.report[f"walk: {unfit}"] += 1
                continue
            self.report["walks added"] += 1
            hands = np.concatenate([np.zeros((max(len(clip) - len(made.hands), 0), 2)), made.hands])[
                -len(clip) :
            ]
            yield replace(made, clip=clip, hands=hands), later

    def _free_seats(self, clip: Clip, phases: Phases) -> Iterator[tuple[FittingPiece, Goal, bool]]:
        """Yield seats near the captured height that the clip does not walk through, and whether they are turned."""
        level = sit_fit.seat_height(clip, (phases.hold.start + phases.hold.stop) // 2)
        reached = np.flatnonzero(np.abs(self.levels - level) < REACH)
        # Heights near the captured one need smaller changes.
        nearness = np.exp(-(((self.levels[reached] - level) / NEAR) ** 2)) * self.chances[reached]
        # Used pieces, and those with failed tries, come later, so that all pieces are covered.
        nearness /= np.array([1 + self.used[self.seats[k][0].index] for k in reached]) ** 2
        order = np.argsort(-nearness * self.rng.random(len(reached)))[:LOOKED_AT]
        facing = sit_fit.facing(clip, phases)
        for k in reached[order]:
            piece, goal = self.seats[k]
            goal, sideways = self._turned(piece, goal)
            if self._walks_through(facing, phases, piece, goal):
                self.report["tried: walks through it"] += 1
            else:
                yield piece, goal, sideways

    def _walks_through(self, facing: Clip, phases: Phases, piece: FittingPiece, goal: Goal) -> bool:
        """Return whether the path to or from a seat crosses its piece: a quick check before fitting."""
        frames = np.arange(len(facing))
        away = (frames < phases.down - 12) | (frames > phases.up_end + 12)
        surface = piece.seat_surface(goal)
        ahead = max(surface.edge - STANDS, 0.0)
        at = surface.frame.to_piece(facing.root[away] + [0.0, 0.0, ahead])[:, [0, 2]]
        low, high = (getattr(piece.triangles, side)(axis=(0, 1))[[0, 2]] for side in ("min", "max"))
        over = ((at > low - BODY) & (at < high + BODY)).all(1)
        # Standing close to the front of the seat is checked after fitting, with the final feet.
        close = (facing.root[away, 2] > 0) & (np.abs(facing.root[away, 0]) < 0.3)
        return bool((over & ~close).any())

    def _on(
        self, piece: FittingPiece, goal: Goal, sideways: bool, clip: Clip, phases: Phases
    ) -> Fitted | None:
        """Return the sit fitted to one seat, or None; the report counts the reason."""
        surface = piece.seat_surface(goal)
        shares = MODES if surface.backed and not sideways else WITHOUT_BACK
        mode = str(self.rng.choice(list(shares), p=list(shares.values())))
        try:
            made = sit_fit.fit(clip, phases, surface, piece.field, mode, self.rng)
            why = fault(made.clip)
            if why is not None:
                raise sit_fit.Unfit(why)
        except sit_fit.Unfit as unfit:
            self.report[f"tried: {unfit}"] += 1
            self.used[piece.index] += IN_VAIN
            return None
        self.report["kept"] += 1
        self.used[piece.index] += 1
        self.report[f"kept {mode}{' backed' if surface.backed else ''}"] += 1
        self.report["kept sideways"] += int(sideways)
        self.owed.append(owed(clip, made.clip))
        self.fitted.append(made)
        return made

    def _turned(self, piece: FittingPiece, goal: Goal) -> tuple[Goal, bool]:
        """Return the goal, in SIDEWAYS of the cases turned over a side or a corner, and whether it is."""
        if piece.category not in SIDEWAYS_ON or self.rng.random() > SIDEWAYS:
            return goal, False
        turn = self.rng.choice([-1.0, 1.0]) * self.rng.uniform(*TURNS)
        return replace(goal, direction=rotation.rotate(rotation.about_y(turn), goal.direction)), True

    def _sequence(
        self, made: Fitted, phases: Phases, piece: FittingPiece, place: tuple[float, float, float]
    ) -> Sequence:
        """Return the sequence with its goals: optionally a way-point, the resting pelvis, then way-points."""
        clip = made.clip
        count = len(clip)
        yaw = headings(clip.root, clip.rotations)
        pelvis = np.median(clip.root[phases.hold], axis=0)
        goal = np.tile([*pelvis, 0.0, 0.0, 1.0], (count, 1))
        action = np.full(count, 3)
        by_way_point(goal, action, clip.root, yaw, phases.down, self.rng)
        if count > phases.up_end + 20:
            leave = phases.seat_end - int(self.rng.integers(0, 12))
            goal[leave:], action[leave:] = way_points(clip.root, yaw, clip.labels, leave, count, self.rng)
        ends_seated = phases.seat_end >= count - 2
        return Sequence(
            "sit", clip.root, clip.rotations, clip.labels, clip.feet, clip.bad, goal, action, piece.index, place,
            open_start=True, open_end=not ends_seated and clip.labels[-1] in ("walk", "run"), hands=made.hands,
        )  # fmt: skip


def approach_alone(joined: Clip, fitted: Clip, shift: int) -> Clip:
    """Return a walk joined to the fitted sit, with newly locked feet in the walk only.

    The sit is ``shift`` frames later than in ``fitted``.
    """
    count = min(len(joined), len(fitted))
    tail = slice(len(joined) - count, len(joined))
    frames = np.arange(len(joined))[tail] - shift  # in the fitted clip
    first = int(max(frames[0], 0))
    share = smoothstep((frames - first - LED_IN) / LED_IN)
    root, rotations = joined.root.copy(), joined.rotations.copy()
    after, turns = fitted.root[-count:], fitted.rotations[-count:]
    root[tail] += share[:, None] * (after - root[tail])
    same = np.where((rotations[tail] * turns).sum(-1, keepdims=True) < 0, -turns, turns)
    rotations[tail] = rotation.slerp(rotations[tail], same, share[:, None])
    return replace(joined, root=root, rotations=rotation.continuous(rotations))
