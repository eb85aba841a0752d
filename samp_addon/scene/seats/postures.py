"""Scores of sitting or lying at a place: support below, free space for torso, thighs and shins, a back behind.

Places are x and z (N, 2) in the rotated frame of a SupportMap; yaws (N,) are relative to it, 0 facing its +Z. Scores
are between 0 (impossible) and 1. Lengths are in metres, of an adult of average height.
"""

from __future__ import annotations

import numpy as np

from ...easing import smoothstep
from .probes import (
    at_bodies,
    blocked_share,
    edge_distance,
    first_hit,
    lattice,
    lines_blocked,
    share_within,
    side_edge_distance,
    support_share,
)
from .support import SupportMap

SEAT_TO_PELVIS = 0.18
"""Height of the pelvis joint over the seat: median of 36 captured sits of the default human, measured to the lowest
point of the buttocks. Soft seats are compressed by refinement only."""
BED_TO_PELVIS = 0.12
"""Height of the pelvis joint over the mattress of a body on its back (captured: 0.09 to 0.16)."""
SIT_HEIGHTS = (0.22, 0.86)
LIE_HEIGHTS = (0.08, 0.86)


LOOK = 0.024
"""Metres: spacing of lines that test for thin walls, which are one cell thick."""
BUTTOCK_LEFT, BUTTOCK_RIGHT = lattice((0.03, 0.14), (-0.09, 0.08)), lattice((-0.14, -0.03), (-0.09, 0.08))
THIGH_SUPPORT = lattice((-0.14, 0.14), (0.08, 0.17))
TORSO = lattice((-0.17, 0.17), (-0.10, 0.10))
THIGHS = lattice((-0.17, 0.17), (0.12, 0.50), 0.06, LOOK)
SHINS = lattice((-0.26, 0.26), (0.38, 0.56))
AHEAD = lattice((-0.15, 0.15), (0.14, 0.40), 0.05, LOOK)
AROUND = np.concatenate(
    [
        r * np.stack([np.sin(a), np.cos(a)], -1)
        for r in (0.26, 0.34, 0.42)
        for a in [np.arange(16) * np.pi / 8]
    ]
)
BODY_SUPPORT = lattice((-0.16, 0.16), (-0.52, 0.60), 0.06)
BODY = lattice((-0.19, 0.19), (-0.55, 0.62), 0.07)
SHOULDER_SIDES = np.concatenate(
    [lattice((a, b), (-0.55, 0.15), 0.03) for a, b in ((-0.26, -0.19), (0.19, 0.26))]
)
HEAD = lattice((-0.09, 0.09), (-0.78, -0.58), 0.05)
FEET = lattice((-0.14, 0.14), (0.66, 0.90), 0.06)
BEYOND_HEAD = lattice((-0.2, 0.2), (-1.30, -0.70), 0.08, LOOK)
BEYOND_FEET = BEYOND_HEAD * [1.0, -1.0]


def to_pelvis(upright: np.ndarray) -> np.ndarray:
    """Return the metres (T,) from a surface up to the pelvis that rests on it.

    upright: (T,) cosines between trunk and vertical.
    """
    return BED_TO_PELVIS + (SEAT_TO_PELVIS - BED_TO_PELVIS) * smoothstep(upright)


def surface_height(grid: SupportMap, places: np.ndarray, radius: float = 0.09) -> np.ndarray:
    """Return the median height (N,) of the supporting surface around the places, metres over the floor.

    NaN where less than half of the surroundings support.
    """
    patch = lattice((-radius, radius), (-radius, radius), radius / 3)
    heights = np.sort(grid.height(places[:, None] + patch), axis=1)  # NaN is sorted last
    known = np.isfinite(heights).sum(axis=1)
    median = heights[np.arange(len(places)), np.maximum(known - 1, 0) // 2]
    return np.where(2 * known >= len(patch), median, np.nan)


def sit_score(grid: SupportMap, places: np.ndarray, yaws: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Score (N,) sitting with the pelvis over the places, facing the yaws, on seats at these heights (N,)."""
    rows = np.flatnonzero(np.isfinite(height) & (height >= SIT_HEIGHTS[0]) & (height <= SIT_HEIGHTS[1]))
    value = np.ones(len(rows))
    # The most selective tests come first, so that the others process few candidates.
    for test in (_sit_support, _shins_free, _torso_free, _thighs_free, _free_ahead, _sit_comfort):
        value = value * test(grid, places[rows], yaws[rows], height[rows])
        rows, value = rows[value > 0], value[value > 0]
    score = np.zeros(len(places))
    score[rows] = value
    return score


def _sit_support(grid: SupportMap, places: np.ndarray, yaws: np.ndarray, height: np.ndarray) -> np.ndarray:
    sides = [support_share(grid, places, yaws, height, part) for part in (BUTTOCK_LEFT, BUTTOCK_RIGHT)]
    thighs = support_share(grid, places, yaws, height, THIGH_SUPPORT)
    worst = np.minimum(*sides)
    return np.where(
        (worst >= 0.62) & (thighs >= 0.35), 0.5 * worst + 0.25 * sum(sides) / 2 + 0.25 * thighs, 0.0
    )


def _shins_free(grid: SupportMap, places: np.ndarray, yaws: np.ndarray, height: np.ndarray) -> np.ndarray:
    at = at_bodies(places, yaws, SHINS)
    below = grid.blocked(at, np.minimum(0.12, height - 0.12)[:, None], (height - 0.04)[:, None])
    # A mattress may be a hollow sheet: no shins below the surface where it continues.
    on = grid.height(at) > height[:, None] - 0.12
    return _share_free((below | on).mean(axis=1), 0.09)


def _torso_free(grid: SupportMap, places: np.ndarray, yaws: np.ndarray, height: np.ndarray) -> np.ndarray:
    return _share_free(blocked_share(grid, places, yaws, TORSO, height + 0.13, height + 0.60), 0.06)


def _thighs_free(grid: SupportMap, places: np.ndarray, yaws: np.ndarray, height: np.ndarray) -> np.ndarray:
    return _share_free(lines_blocked(grid, places, yaws, THIGHS, height + 0.08, height + 0.24), 0.26)


def _free_ahead(grid: SupportMap, places: np.ndarray, yaws: np.ndarray, height: np.ndarray) -> np.ndarray:
    return _share_free(lines_blocked(grid, places, yaws, AHEAD, height + 0.14, height + 0.60), 0.30)


def _share_free(hit: np.ndarray, most: float) -> np.ndarray:
    return np.where(hit <= most, 1 - hit, 0.0)


def _sit_comfort(grid: SupportMap, places: np.ndarray, yaws: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Score (N,) comfort: a back close behind and square to the body, a square edge in front, space at the sides."""
    ranges = np.arange(0.06, 0.45, 0.02)
    back = np.stack(
        [
            first_hit(grid, places, yaws, -ranges, x, height + 0.10, height + 0.42)
            for x in (-0.12, -0.05, 0.05, 0.12)
        ],
        1,
    )
    has_back = np.clip((0.42 - np.median(back, axis=1)) / 0.22, 0, 1) * np.mean(back < 0.42, axis=1)
    skew = np.where(has_back > 0.3, (back[:, 0] - back[:, -1]) / 0.07, 0.0)
    front = np.stack([edge_distance(grid, places, yaws, ranges, x, height) for x in (-0.11, 0.0, 0.11)], 1)
    straight = np.exp(-(skew**2) - (np.ptp(front, axis=1) / 0.09) ** 2)
    side = np.minimum(*[side_edge_distance(grid, places, yaws, ranges, s, height) for s in (-1, 1)])
    behind = np.minimum(edge_distance(grid, places, yaws, -ranges, 0.0, height), 0.2) / 0.2
    room = np.clip(side / 0.22, 0.3, 1)
    # High seats have to be climbed and very low ones squatted on: possible, but rare.
    tall = np.interp(height, [0.22, 0.36, 0.52, 0.70, 0.86], [0.55, 1.0, 1.0, 0.55, 0.35])
    leaning = np.maximum(has_back, 0.4 * behind)
    # Places higher than an adjacent seat are its armrest, back or pillow.
    drop = height[:, None] - grid.height(at_bodies(places, yaws, AROUND))
    lower = (drop > 0.07) & (drop < 0.45) & (drop < height[:, None] - SIT_HEIGHTS[0] + 0.05)
    over = lower.sum(axis=1) / np.maximum(np.isfinite(drop).sum(axis=1), 8)
    proper = np.interp(over, [0.2, 0.5], [1.0, 0.0])
    return tall * (0.25 + 0.75 * leaning) * (0.2 + 0.8 * straight) * room * proper


def lie_score(grid: SupportMap, places: np.ndarray, yaws: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Score (N,) lying on the back with the pelvis over the places; the yaws point from head to feet."""
    rows = np.flatnonzero(np.isfinite(height) & (height >= LIE_HEIGHTS[0]) & (height <= LIE_HEIGHTS[1]))
    score = np.zeros(len(places))
    body = support_share(grid, places[rows], yaws[rows], height[rows], BODY_SUPPORT, 0.10)
    rows, body = rows[body >= 0.86], body[body >= 0.86]
    at = places[rows], yaws[rows], height[rows]
    bump = blocked_share(grid, at[0], at[1], BODY, at[2] + 0.20, at[2] + 0.50)
    head = share_within(grid, *at, HEAD, -0.06, 0.24)
    feet_hit = blocked_share(grid, at[0], at[1], FEET, at[2] + 0.22, at[2] + 0.5)
    head_hit = blocked_share(grid, at[0], at[1], HEAD, at[2] + 0.35, at[2] + 0.55)
    feet = share_within(grid, *at, FEET, -0.10, 0.22)
    good = (bump <= 0.06) & (head >= 0.75) & (feet_hit <= 0.1) & (head_hit <= 0.1)
    evidence = _head_evidence(grid, *at)
    headed = np.clip(0.5 + evidence, 0.1, 1.0)
    ranges = np.arange(0.06, 0.75, 0.03)
    sides = np.stack(
        [edge_distance(grid, at[0], at[1] + s * np.pi / 2, ranges, 0.0, at[2]) for s in (-1, 1)], 1
    )
    within_reach = np.interp(sides.min(axis=1), [0.17, 0.28, 0.42, 0.60, 0.75], [0.5, 0.85, 1.0, 1.0, 0.6])
    tall = np.interp(at[2], [0.08, 0.2, 0.6, 0.86], [0.7, 1.0, 1.0, 0.4])
    quarter = (at[1] + np.pi / 4) % (np.pi / 2) - np.pi / 4
    straight = 0.3 + 0.7 * np.exp(-((quarter / np.radians(12)) ** 2))
    long_way = np.abs(np.stack([np.sin(at[1]), np.cos(at[1])], -1)) @ (grid.high - grid.low)
    along = np.where(long_way >= 0.9 * (grid.high - grid.low).max(), 1.0, 0.65)
    # Shoulders and arms need more space than the trunk: bodies keep away from the back of a sofa.
    side_share = blocked_share(grid, *at[:2], SHOULDER_SIDES, at[2] + 0.10, at[2] + 0.45)
    room = 1 - 0.33 * side_share
    value = room * body * head * (1 - 4 * bump) * (0.6 + 0.4 * feet) * (0.4 + 0.6 * headed)
    value *= within_reach * tall * straight * along
    score[rows] = np.where(good, value, 0.0)
    return score


def head_evidence(grid: SupportMap, place: np.ndarray, yaw: float) -> float:
    """Return the evidence that a body that lies at a place (2,) has its head at the right end; negative if not."""
    places, yaws = place[None], np.array([yaw])
    height = surface_height(grid, places)
    return float(_head_evidence(grid, places, yaws, height)[0]) if np.isfinite(height[0]) else 0.0


def _head_evidence(grid: SupportMap, places: np.ndarray, yaws: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Return the evidence (N,) for the head: it goes to the raised end, a headboard or a pillow; to the higher one if
    both are raised."""
    at = places, yaws, height
    boards = [
        lines_blocked(grid, *at[:2], part, at[2] + 0.06, at[2] + 0.5) for part in (BEYOND_HEAD, BEYOND_FEET)
    ]
    tops = [
        lines_blocked(grid, *at[:2], part, at[2] + 0.42, at[2] + 0.9) for part in (BEYOND_HEAD, BEYOND_FEET)
    ]
    pillows = [_pillow_share(grid, *at, part) for part in (HEAD, FEET)]
    return 1.5 * (boards[0] - boards[1]) + 0.5 * (tops[0] - tops[1]) + (pillows[0] - pillows[1])


def _pillow_share(
    grid: SupportMap, places: np.ndarray, yaws: np.ndarray, height: np.ndarray, part: np.ndarray
) -> np.ndarray:
    """Return the share (N,) of a part's points where something as thick as a pillow is on the surface."""
    return share_within(grid, places, yaws, height, part, 0.05, 0.22)
