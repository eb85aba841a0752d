"""Lying with a raised back: loungers, recliners and deck chairs, whose backs lean by up to 50 degrees.

The body has its legs on a level part and its trunk on a plane that rises behind the pelvis. Lengths are in metres, of
an adult of average height.
"""

from __future__ import annotations

import numpy as np

from ...motion import Goal
from .probes import at_bodies, edge_distance, lattice, support_share
from .support import SupportMap

ANGLES = (np.radians(13.0), np.radians(53.0))
"""Radians over the horizontal of backs that are leaned on; flatter ones are lain on like a mattress."""
HINGE = 0.03
"""Metres behind the pelvis joint at which the back begins to rise: buttocks fill the corner."""
UNEVEN, UNEVEN_SHARE = 0.06, 0.2
"""Metres between a point of the back and its plane, and their share of the height of the back: pillows are steps."""
EVEN_SHARE = 0.8
"""Least share of the points of a back that are on its plane."""
LEVEL = 0.11
"""Metres by which leg rests may be higher or lower than the seat."""
LEG_SHARE = 0.85
SLID = 0.04
"""Metres between the surfaces under pelvis and thighs."""
HEIGHTS = (0.08, 0.75)
"""Metres over the floor of a seat with a leg rest."""
LEGS = lattice((-0.13, 0.13), (0.0, 0.58), 0.06)
THIGHS = lattice((-0.13, 0.13), (0.06, 0.36), 0.06)
BACK = lattice((-0.13, 0.13), (-0.56, -0.17), 0.05)
CROWN = 0.75
"""Metres over the seat of the highest point of a back that is looked at."""
HALF_WIDTH = 0.13


def recline_score(grid: SupportMap, places: np.ndarray, yaws: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Score (N,) lying on a raised back with the pelvis over the places; the yaws point from head to feet.

    height: (N,) of the seat over the floor.
    """
    score = np.zeros(len(places))
    rows = np.flatnonzero(np.isfinite(height) & (height >= HEIGHTS[0]) & (height <= HEIGHTS[1]))
    legs = support_share(grid, places[rows], yaws[rows], height[rows], LEGS, LEVEL)
    rows, legs = rows[legs >= LEG_SHARE], legs[legs >= LEG_SHARE]
    if not len(rows):
        return score
    at = places[rows], yaws[rows]
    rise = grid.top(at_bodies(*at, BACK)) - height[rows, None]
    angle, share, spread = _plane(rise, -BACK[:, 1])
    good = (share >= EVEN_SHARE) & (angle >= ANGLES[0]) & (angle <= ANGLES[1])
    ranges = np.arange(0.06, 0.75, 0.03)
    sides = np.stack(
        [edge_distance(grid, at[0], at[1] + s * np.pi / 2, ranges, 0.0, height[rows]) for s in (-1, 1)], 1
    )
    reach = np.interp(sides.min(axis=1), [0.15, 0.28, 0.42, 0.75], [0.5, 0.9, 1.0, 0.8])
    middle = np.exp(-((np.ptp(np.minimum(sides, 0.5), axis=1) / 0.4) ** 2))
    quarter = (at[1] + np.pi / 4) % (np.pi / 2) - np.pi / 4
    straight = 0.3 + 0.7 * np.exp(-((quarter / np.radians(12)) ** 2))
    # A pelvis on the slope itself would slide down to the thighs' level.
    level = np.nanmedian(grid.height(at_bodies(*at, THIGHS)), axis=1) - height[rows]
    even = share * np.exp(-((spread / UNEVEN) ** 2) - (level / SLID) ** 2)
    value = legs * even * reach * middle * straight
    score[rows] = np.where(good, value, 0.0)
    return score


def back_angle(points: np.ndarray, goal: Goal, seat: float) -> float:
    """Return the angle, radians over the horizontal, of the back behind a goal to lie; 0 where the body lies flat.

    points: (N, 3) on the object, twenty thousand or more. seat: height of the surface under the pelvis.
    """
    away = points - goal.position
    behind = -(away @ goal.direction)
    aside = away @ np.array([goal.direction[2], 0.0, -goal.direction[0]])
    rise = points[:, 1] - seat
    near = (np.abs(aside) < HALF_WIDTH) & (rise > -LEVEL) & (rise < CROWN)
    steps = np.unique(-BACK[:, 1])
    size = steps[1] - steps[0]
    tops = np.full(len(steps), np.nan)
    for k, step in enumerate(steps):
        row = rise[near & (np.abs(behind - step) < size / 2)]
        if len(row):
            tops[k] = row.max()
    angle, share, _ = (float(values[0]) for values in _plane(tops[None], steps))
    return angle if share >= EVEN_SHARE and ANGLES[0] <= angle <= ANGLES[1] else 0.0


def _plane(rise: np.ndarray, behind: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fit planes through the hinge to heights (N, P) over the seat at distances (P,) behind the pelvis.

    Return the angles (N,), the shares (N,) of points on the planes, and the mean distances (N,) from them.
    """
    run = behind - HINGE
    missing = ~np.isfinite(rise)
    ratio = np.sort(np.where(missing, np.inf, rise / run), axis=1)
    known = np.maximum((~missing).sum(axis=1), 1)
    slope = ratio[np.arange(len(rise)), (known - 1) // 2]
    slope = np.where(np.isfinite(slope), slope, 0.0)
    off = np.where(missing, np.inf, np.abs(rise - slope[:, None] * run))
    most = np.clip(UNEVEN_SHARE * slope * run.max(), UNEVEN / 2, UNEVEN)[:, None]
    return np.arctan(slope), (off < most).mean(axis=1), np.minimum(off, most).mean(axis=1)
