"""Stances: which foot stands, and from which frame to which. Network frame, metres.

With contact labels a foot stands where its label says so and its ball is slow. Without them it stands where its sole
is slow, upright and near the ground (Long-term motion, section 3.4: the nearer foot between two frames is the stable
one).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...evaluation.feet import smoothed_speeds
from ...frames import direction_yaw
from ..runs import runs

SMOOTHED = 3  # frames over which the speed of a foot is averaged

# Stances by contact labels.
UNLOCK_RADIUS = 0.12  # metres of drift within a stance that count as a step
SWING_SPEED = 0.45  # m/s: a faster foot is in the air, whatever its label says
STEP_TIME = 0.3  # seconds of a step between two stances of one contact run

# Stances by geometry. Without labels, drift and speed are judged more strictly.
NEAR_GROUND = 0.05  # metres from the ground within which a sole can stand
RISEN = 0.01  # metres over the stance's usual height at which the sole has left the ground
SLOW = 0.40  # m/s of the sole
STEPPED = 0.10  # metres of drift within a stance that count as a step
TURNED = math.radians(30)  # turn of a sole within a stance that counts as a step
FLAT = 0.035  # metres by which the heights of heel and ball of a flat foot differ
UPRIGHT = 0.75  # cosine between the foot's up axis and the vertical
SHORTEST = 4  # frames at 30 fps
BRIDGED = 12  # frames at 30 fps: longest gap between the stances of both feet that is closed


@dataclass(frozen=True)
class Stance:
    """A foot that stands from frame ``first`` up to, but not including, ``last``.

    flat: the part of it, likewise, with heel and ball on the ground, or None.
    """

    first: int
    last: int
    flat: tuple[int, int] | None = None


def standing(found: Sequence[Stance], count: int) -> np.ndarray:
    """Return flags (count,) of the frames that belong to a stance."""
    flags = np.zeros(count, bool)
    for stance in found:
        flags[stance.first : stance.last] = True
    return flags


def from_contacts(
    ball: np.ndarray, contact: np.ndarray, fps: float, fastest: float = SWING_SPEED
) -> list[Stance]:
    """Return the stances of a foot by its contact labels.

    ball: (T, 3) of the ball joint. contact: (T,) flags. fastest: m/s of a foot that may stand.
    """
    if len(ball) < 2:
        return []
    slow = smoothed_speeds(ball[:, [0, 2]], fps, SMOOTHED) < fastest
    free = max(1, round(STEP_TIME * fps / 2))
    return [
        Stance(*span)
        for first, last in runs(contact & slow)
        for span in _split(ball[:, [0, 2]], first, last, radius=UNLOCK_RADIUS, free=free, shortest=3)
    ]


def from_ground(
    ends: Sequence[np.ndarray], heights: Sequence[np.ndarray], up: np.ndarray, fps: float
) -> list[Stance]:
    """Return the stances of a foot by the ground under it.

    ends: heel and ball of the sole, (T, 3) each. heights: of both over the ground, (T,) each, NaN where there is no
    ground. up: (T,) cosines between the foot's up axis and the vertical.
    """
    if len(up) < 2:
        return []
    speed = np.min([smoothed_speeds(end, fps, SMOOTHED) for end in ends], axis=0)
    low = np.nanmin(np.nan_to_num(np.abs(heights), nan=1.0), axis=0)
    shortest = max(2, round(SHORTEST * fps / 30))
    pointing = _pointing(ends[1] - ends[0])
    found = []
    for first, last in runs((low < NEAR_GROUND) & (speed < SLOW) & (up > UPRIGHT), shortest, 2):
        down = np.flatnonzero(low[first:last] < np.percentile(low[first:last], 20) + RISEN)
        start, stop = first + down[0], first + down[-1] + 1
        found += [
            part
            for span in _split(
                ends[1][:, [0, 2]], start, stop, radius=STEPPED, free=shortest, shortest=shortest
            )
            for part in _split(pointing, *span, radius=TURNED, free=shortest, shortest=shortest)
        ]
    return [Stance(first, last, _flat_part(heights, first, last)) for first, last in found]


def _pointing(along: np.ndarray) -> np.ndarray:
    """Return the facings of a sole as places (T, 2) whose distances are turns in radians.

    along: (T, 3), from heel to ball.
    """
    facing = np.unwrap(direction_yaw(along))
    return np.stack([facing, np.zeros_like(facing)], axis=-1)


def bridge(feet: Sequence[Sequence[Stance]], supported: np.ndarray, fps: float) -> list[list[Stance]]:
    """Return the stances of both feet, extended over short gaps in which neither stands but the body is supported.

    While walking there is always a foot on the ground. supported: (T,) flags.
    """
    longest = round(BRIDGED * fps / 30)
    order = sorted(
        (stance.first, stance.last, side, k) for side in (0, 1) for k, stance in enumerate(feet[side])
    )
    feet = [list(stances) for stances in feet]
    until, latest = None, None
    for first, last, side, k in order:
        gap = 0 if until is None else first - until
        if 0 < gap <= longest and latest[0] != side and supported[until:first].mean() > 0.5:
            half = until + (gap + 1) // 2
            feet[latest[0]][latest[1]] = replace(feet[latest[0]][latest[1]], last=half)
            feet[side][k] = replace(feet[side][k], first=half)
        if until is None or last > until:
            until, latest = last, (side, k)
    return feet


def _split(
    places: np.ndarray, first: int, last: int, *, radius: float, free: int, shortest: int
) -> list[tuple[int, int]]:
    """Split a stance (first, last) where its places (T, 2) drift farther than ``radius`` from their mean so far.

    ``free`` frames before and after each split belong to no stance: there the foot moves from one to the next.
    """
    out = []
    start, x, z = first, 0.0, 0.0  # sums since the start of the present stance
    for t, place in enumerate(places[first:last].tolist(), start=first):
        count = t - start
        if count > 0 and math.hypot(place[0] - x / count, place[1] - z / count) > radius:
            out.append((start, t - free))
            start, x, z = t + free, 0.0, 0.0
        if t >= start:
            x, z = x + place[0], z + place[1]
    return [(a, b) for a, b in [*out, (start, last)] if b - a >= shortest]


def _flat_part(heights: Sequence[np.ndarray], first: int, last: int) -> tuple[int, int] | None:
    """Return the longest part of a stance with heel and ball on the ground."""
    heel, ball = (np.nan_to_num(height[first:last], nan=1.0) for height in heights)
    flat = (np.abs(heel - ball) < FLAT) & (np.maximum(heel, ball) < NEAR_GROUND)
    found = runs(flat, 2, 1)
    if not found:
        return None
    a, b = max(found, key=lambda run: run[1] - run[0])
    return first + a, first + b
