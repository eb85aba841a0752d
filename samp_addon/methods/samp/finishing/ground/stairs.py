"""Walks carried onto stairs: each stance onto a tread, the swings over the nosings, the pelvis up or down with them.

No captured walk climbs stairs. A walk on the unfolded path (unfolding.py) has a step for each tread; here its steps are
shortened to the treads by inverse kinematics. Network frame, metres.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import gaussian_filter1d

from .....easing import anticipate, smoothstep
from .....motion import Motion
from .....refine.feet import stances
from .....refine.feet.corrections import Correction, apply
from .....refine.feet.foot import FEET, Foot, sole_points, toe_tips
from .....scene.flights import Flight
from ...unfolding import Unfolded
from .terrain import Ground

CLEAR, BEHIND, HOLD_ON, EDGE = 0.015, 0.01, 0.04, 0.015
"""Metres: from a toe to the riser in front of it, from a heel to the riser behind it, of the ball on its tread, and
from the ball to the edge over which the toes reach on the way down."""

SKIPPED = 1.0
"""Cost, square metres, of a tread that no foot stands on."""

OVER, BESIDE = 0.02, 0.015
"""Metres of a swinging sole over the nosings, and before and behind its points."""

EARLY = 0.55
"""Share of a swing in which a foot rises, or, on the way down, sinks."""

ARRIVED = 0.92
"""Share of a swing in which its length is corrected, so that the heel is over its tread before it sinks."""

CROUCH, RISEN = 0.02, 0.15
"""Metres by which the pelvis is lower over a foot on stairs, and the share of a riser that it has risen when the upper
foot touches down."""

SIGMA = 3.0
"""Frames at 30 fps of the Gaussian over the pelvis' way."""


@dataclass
class _Step:
    """A stance.

    foot: number in FEET. first, last: frames. place: (3,) of the ball on the stretched floor. reach: metres from the
    ball to the rearmost and the foremost point of the sole, along the flight. flight: number, or -1. folded: (3,) place
    on the real path, before it is put onto a tread. offset: (3,) from ``place`` to its place on the real ground.
    """

    foot: int
    first: int
    last: int
    place: np.ndarray
    reach: tuple[float, float]
    flight: int
    folded: np.ndarray
    offset: np.ndarray | None = None

    @property
    def middle(self) -> float:
        return (self.first + self.last - 1) / 2


@dataclass(frozen=True)
class Under:
    """The ground of flights under a body. flights: on its path. number: (T,) of the flight in each frame, or -1."""

    flights: Sequence[Flight]
    number: np.ndarray

    def heights(self, points: np.ndarray, beside: float = 0.0) -> np.ndarray:
        """Return the greatest heights (T,) of the ground under points (T, 3), and so far before and behind them; NaN
        beside the flights."""
        made = np.full(len(points), np.nan)
        for k, flight in enumerate(self.flights):
            rows = self.number == k
            found = [
                flight.heights(points[rows] + away * flight.direction) for away in (-beside, 0.0, beside)
            ]
            made[rows] = np.fmax.reduce(found)
        return made


def climb(motion: Motion, travelled: np.ndarray, unfolded: Unfolded, ground: Ground) -> Motion:
    """Return the motion on the real path.

    motion: on the stretched path over a floor at height 0, feet locked. travelled: (T,) metres along that path. ground:
    heights beside the flights. Raises ValueError without motion.contacts.
    """
    if motion.contacts is None:
        raise ValueError("a walk over stairs needs the motion's contacts")
    steps = _steps(motion, travelled, unfolded)
    if not steps:
        return motion
    for number, flight in enumerate(unfolded.flights):
        _onto_treads([step for step in steps if step.flight == number], flight)
    for step in steps:
        if step.flight < 0:
            _onto_ground(step, steps, ground)
    over = _root_offset(motion, steps)
    moved = replace(motion, root=motion.root + over)
    under = Under(unfolded.flights, unfolded.flight_at(travelled))
    corrections = [_correction(motion, number, steps, over, under) for number in range(len(FEET))]
    return apply(moved, corrections, lambda tips: np.nan_to_num(under.heights(tips), nan=-1e3))


def _steps(motion: Motion, travelled: np.ndarray, unfolded: Unfolded) -> list[_Step]:
    """Return all stances of both feet in order of time."""
    positions, globals_ = motion.forward_kinematics()
    found = []
    for number, foot in enumerate(FEET):
        ball = positions[:, foot.ball]
        heel, _ = sole_points(positions, globals_, motion.rest_joints, foot.side)
        tip = toe_tips(positions, globals_, motion.rest_joints, foot.side)
        for one in stances.from_contacts(ball, motion.contacts[:, foot.column] > 0.5, motion.fps):
            part = slice(one.first, one.last)
            place = ball[part].mean(0) * [1.0, 0.0, 1.0]
            gone = float(travelled[part].mean())
            flight = int(unfolded.flight_at(np.array(gone)))
            ahead = unfolded.flights[flight].direction
            ends = [(point[part] - place) @ ahead for point in (heel, tip)]
            found.append(
                _Step(
                    number,
                    one.first,
                    one.last,
                    place,
                    (np.min(ends), np.max(ends)),
                    flight,
                    unfolded.folded(place, gone),
                )
            )
    return sorted(found, key=lambda step: step.middle)


def _onto_treads(steps: Sequence[_Step], flight: Flight) -> None:
    """Choose a tread for each stance of a flight, in order of time, and place it there."""
    if not steps:
        return
    count = len(flight.treads)
    wanted = np.array([float(flight.along(step.folded)) for step in steps])
    places = np.array(
        [
            [_on_tread(flight, k, step, at) for k in range(count)]
            for step, at in zip(steps, wanted, strict=True)
        ]
    )
    cost = np.square(places - wanted[:, None])
    total, came = cost[0], []
    for row in cost[1:]:
        jump = np.arange(count)[:, None] - np.arange(count)  # to tread k from tread j
        change = np.where(jump < 0, np.inf, SKIPPED * np.maximum(jump - 1, 0))
        options = total + change
        came.append(options.argmin(1))
        total = options.min(1) + row
    tread = int(total.argmin())
    for k in range(len(steps) - 1, -1, -1):
        step = steps[k]
        shift = (places[k, tread] - wanted[k]) * flight.direction
        step.offset = step.folded + shift - step.place
        step.offset[1] = flight.treads[tread]
        tread = int(came[k - 1][tread]) if k else tread


def _on_tread(flight: Flight, tread: int, step: _Step, wanted: float) -> float:
    """Return the place, metres along the flight, of a ball on a tread, as near to ``wanted`` as the foot fits."""
    low, high = -np.inf, np.inf
    behind, ahead = step.reach
    if tread > 0:
        riser, climbs = flight.risers[tread - 1], flight.treads[tread] > flight.treads[tread - 1]
        low = riser + (HOLD_ON if climbs else BEHIND - behind)
    if tread < len(flight.risers):
        riser, climbs = flight.risers[tread], flight.treads[tread + 1] > flight.treads[tread]
        high = riser - (CLEAR + ahead if climbs else EDGE)
    return float(np.clip(wanted, low, high)) if low <= high else (low + high) / 2


def _onto_ground(step: _Step, steps: Sequence[_Step], ground: Ground) -> None:
    """Place a stance beside all flights on the ground."""
    near = min((s for s in steps if s.flight >= 0), key=lambda s: abs(s.middle - step.middle), default=None)
    step.offset = step.folded - step.place
    expected = 0.0 if near is None or near.offset is None else near.offset[1]
    height = ground((step.folded * [1.0, 0.0, 1.0] + [0.0, expected, 0.0])[None])[0]
    step.offset[1] = height if np.isfinite(height) else expected


def _root_offset(motion: Motion, steps: Sequence[_Step]) -> np.ndarray:
    """Return by how much the pelvis moves (T, 3)."""
    frames, count = np.arange(len(motion)), len(steps)
    middles = np.array([step.middle for step in steps]) + 1e-3 * np.arange(count)
    offsets = np.array([step.offset for step in steps])
    over = np.stack([np.interp(frames, middles, offsets[:, k]) for k in (0, 2)], -1)
    times, heights = [], []
    for k, (step, height) in enumerate(zip(steps, offsets[:, 1], strict=True)):
        changes = k > 0 and abs(height - offsets[k - 1, 1]) > 1e-3
        if changes:
            low, rise = min(height, offsets[k - 1, 1]), abs(height - offsets[k - 1, 1])
            times.append(float(step.first))
            heights.append(low + RISEN * rise)
        level = changes or (k + 1 < count and abs(offsets[k + 1, 1] - height) > 1e-3)
        times.append(step.middle)
        heights.append(height - (CROUCH if level else 0.0))
    order = np.argsort(times, kind="stable")
    times, heights = np.array(times)[order], np.array(heights)[order]
    apart = np.append(True, np.diff(times) > 1e-6)
    times, heights = times[apart], heights[apart]
    up = (
        np.interp(frames, times, heights)
        if len(times) < 2
        else PchipInterpolator(times, heights)(np.clip(frames, times[0], times[-1]))
    )
    made = np.stack([over[:, 0], up, over[:, 1]], -1)
    return gaussian_filter1d(made, SIGMA * motion.fps / 30, axis=0, mode="nearest")


def _correction(
    motion: Motion, number: int, steps: Sequence[_Step], over: np.ndarray, under: Under
) -> Correction:
    """Return the correction of a foot. over: (T, 3) by which the pelvis moves."""
    foot: Foot = FEET[number]
    own = [step for step in steps if step.foot == number]
    positions, globals_ = motion.forward_kinematics()
    ankle, count = positions[:, foot.ankle], len(motion)
    offset, standing = np.zeros((count, 3)), np.zeros(count, bool)
    for step in own:
        offset[step.first : step.last] = step.offset
        standing[step.first : step.last] = True
    if own:
        offset[: own[0].first], offset[own[-1].last :] = own[0].offset, own[-1].offset
    for before, after in zip(own[:-1], own[1:], strict=True):
        frames = np.arange(before.last, after.first)
        gone = ankle[frames] - ankle[before.last - 1]
        way = ankle[after.first] - ankle[before.last - 1]
        share = np.clip((gone * way).sum(-1) / max(float(way @ way), 1e-6), 0.0, 1.0)
        share = np.maximum.accumulate(share)
        change = after.offset - before.offset
        offset[frames] = before.offset + np.minimum(share / ARRIVED, 1.0)[:, None] * change
        rising = share / EARLY if change[1] > 0 else (share - 1 + EARLY) / EARLY
        offset[frames, 1] = before.offset[1] + smoothstep(rising) * change[1]
    if not own:
        offset = over.copy()
    offset[:, 1] += _lift(motion, foot, offset, standing, under)
    return Correction(foot, offset - over, standing, globals_[:, foot.ankle])


def _lift(motion: Motion, foot: Foot, offset: np.ndarray, standing: np.ndarray, under: Under) -> np.ndarray:
    """Return by how much a swinging foot is lifted (T,) over the ground of the flights."""
    positions, globals_ = motion.forward_kinematics()
    heel, ball = sole_points(positions, globals_, motion.rest_joints, foot.side)
    tip = toe_tips(positions, globals_, motion.rest_joints, foot.side)
    need = np.zeros(len(motion))
    for point in (heel, ball, tip):
        placed = point + offset
        height = under.heights(placed, BESIDE)
        need = np.maximum(need, np.nan_to_num(height + OVER - placed[:, 1], nan=0.0))
    need[standing] = 0.0
    lift = np.maximum(anticipate(need, 3, 1.0 * motion.fps / 30), need)
    lift[standing] = 0.0
    return lift
