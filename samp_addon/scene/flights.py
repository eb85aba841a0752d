"""Flights of stairs on a path: their risers and treads. Network frame, metres."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import map_coordinates

from ..frames import ground_lengths
from .distance.solids import overlapping_box

STEP = 0.02
"""Metres between samples of the ground along a path."""

LEAST_RISE, MOST_RISE = 0.08, 0.26
"""Metres: lowest and highest riser. A lower one is a sill or a rug; a higher one cannot be climbed."""

WITHIN = 3
"""Samples within which a riser rises: nosings are bevelled, and treads overhang."""

LONGEST_TREAD = 1.5
"""Metres between two risers of one flight; beyond it begins another one."""

BEND = 0.2
"""Metres by which a path may leave the straight line over a flight."""

NEAR = 0.35
"""Metres between the ground and the straight lines of a path over it: two stairs."""

ASIDE, LANE = 0.4, 0.05
"""Metres: half the width over which the ground of a flight is known, and between its lanes."""

MARGIN, CELL = 0.8, 0.01
"""Metres: length of known ground before and after a flight, and between its samples."""

UPWARD = 0.5
"""Least vertical component of the normal of ground."""


@dataclass(frozen=True)
class Flight:
    """A straight flight of stairs, in the direction in which it is walked, up or down.

    begin, end: metres along the path of the first and the last riser. origin: (3,) of the path at the first riser.
    direction: (3,) horizontal, unit. risers: (R,) metres from the origin. treads: (R + 1,) heights of the floor before,
    the treads, and the floor after. ground: heights (A, C), CELL apart from -MARGIN on, in lanes LANE apart from -ASIDE
    to ASIDE, NaN where there is none.
    """

    begin: float
    end: float
    origin: np.ndarray
    direction: np.ndarray
    risers: np.ndarray
    treads: np.ndarray
    ground: np.ndarray

    @property
    def length(self) -> float:
        """Metres from the first to the last riser."""
        return float(self.risers[-1])

    @property
    def left(self) -> np.ndarray:
        """The horizontal direction (3,) across the flight."""
        return np.array([self.direction[2], 0.0, -self.direction[0]])

    def along(self, points: np.ndarray) -> np.ndarray:
        """Return the metres (...) from the first riser of points (..., 3)."""
        return ((points - self.origin) * self.direction).sum(-1)

    def heights(self, points: np.ndarray) -> np.ndarray:
        """Return the heights (N,) of the ground under points (N, 3), NaN beyond what is known."""
        row = (self.along(points) + MARGIN) / CELL
        lane = (((points - self.origin) * self.left).sum(-1) + ASIDE) / LANE
        # Order 0: the ground between two treads is on one of them.
        return map_coordinates(self.ground, [row, lane], order=0, mode="constant", cval=np.nan)


def find(path: np.ndarray, triangles: np.ndarray) -> list[Flight]:
    """Return the flights on a path (M, 3) over the ground, in order. triangles: (F, 3, 3) of the scene."""
    if len(path) < 2 or np.ptp(path[:, 1]) < LEAST_RISE:
        return []
    lengths = ground_lengths(path)
    at = np.arange(0.0, lengths[-1], STEP)
    line = np.stack([np.interp(at, lengths, path[:, k]) for k in range(3)], -1)
    heights = surface(triangles, line)
    found = []
    for group in _groups(_risers(heights), line):
        one = _flight(group, at, line, heights, triangles)
        if one is not None:
            found.append(one)
    return found


def surface(triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the heights (N,) of the highest surfaces within NEAR of the heights of points (N, 3), NaN for none."""
    made = np.full(len(points), np.nan)
    for part in np.array_split(np.arange(len(points)), max(len(points) // 25, 1)):
        low, high = points[part].min(0) - [0.0, NEAR, 0.0], points[part].max(0) + [0.0, NEAR, 0.0]
        made[part] = _under(overlapping_box(triangles, low, high), points[part])
    return made


def _under(triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    a, b, c = triangles.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    kept = np.abs(normal[:, 1]) > UPWARD * np.linalg.norm(normal, axis=-1)
    a, b, c, area = a[kept], b[kept], c[kept], normal[kept, 1]
    if not len(a):
        return np.full(len(points), np.nan)
    side = lambda p, q, r: (
        (q[..., 2] - p[..., 2]) * (r[..., 0] - p[..., 0]) - (q[..., 0] - p[..., 0]) * (r[..., 2] - p[..., 2])
    )
    place = points[:, None]
    u, v, w = side(b, c, place) / area, side(c, a, place) / area, side(a, b, place) / area
    heights = u * a[:, 1] + v * b[:, 1] + w * c[:, 1]
    there = (np.minimum(np.minimum(u, v), w) >= -1e-9) & (np.abs(heights - place[..., 1]) <= NEAR)
    # The highest: boards have a lower face as well.
    highest = np.where(there, heights, -np.inf).max(1)
    return np.where(np.isfinite(highest), highest, np.nan)


def _risers(heights: np.ndarray) -> list[tuple[int, int]]:
    """Return the first and the last sample of each riser."""
    rise = np.abs(heights[WITHIN:] - heights[:-WITHIN]) >= LEAST_RISE
    edges = np.flatnonzero(np.diff(np.concatenate([[False], rise, [False]]).astype(int)))
    found = []
    for first, last in zip(edges[::2], edges[1::2] - 1 + WITHIN, strict=True):
        # The steepest part lies within: its ends are level.
        jumps = np.flatnonzero(np.abs(np.diff(heights[first : last + 1])) > LEAST_RISE / WITHIN)
        if len(jumps):
            found.append((first + int(jumps[0]), first + int(jumps[-1]) + 1))
    return found


def _groups(risers: list[tuple[int, int]], line: np.ndarray) -> Iterator[list[tuple[int, int]]]:
    """Yield the risers of each straight flight. line: (N, 3) samples of the path."""
    group: list[tuple[int, int]] = []
    for one in risers:
        if group and (
            (one[0] - group[-1][1]) * STEP > LONGEST_TREAD or _bend(line[group[0][0] : one[1] + 1]) > BEND
        ):
            yield group
            group = []
        group.append(one)
    if group:
        yield group


def _bend(line: np.ndarray) -> float:
    """Return the metres by which points (N, 3) leave the straight line between their ends."""
    flat = line[:, [0, 2]] - line[0, [0, 2]]
    length = max(float(np.hypot(*flat[-1])), 1e-9)
    return float(np.abs(flat[:, 0] * flat[-1, 1] - flat[:, 1] * flat[-1, 0]).max()) / length


def _flight(
    group: list[tuple[int, int]], at: np.ndarray, line: np.ndarray, heights: np.ndarray, triangles: np.ndarray
) -> Flight | None:
    """Return the flight of some risers, None where one of them is too high."""
    edges = [0, *(k for riser in group for k in riser), len(line) - 1]
    near = int(LONGEST_TREAD / STEP / 2)
    treads = []
    for k, (first, last) in enumerate(zip(edges[::2], edges[1::2], strict=True)):
        begin = max(first, last - near) if k == 0 else first
        end = min(last, first + near) if k == len(group) else last
        level = heights[begin : end + 1]
        treads.append(float(np.nanmedian(level)) if np.isfinite(level).any() else np.nan)
    rises = np.abs(np.diff(treads))
    if not np.isfinite(rises).all() or rises.max() > MOST_RISE:
        return None
    places = np.array([(at[first] + at[last]) / 2 for first, last in group])
    begin, end = group[0][0], group[-1][1]
    # A single riser has no length of its own: the path beside it gives the direction.
    wide = line[min(end + 10, len(line) - 1)] - line[max(begin - 10, 0)]
    direction = np.array([wide[0], 0.0, wide[2]]) / max(float(np.hypot(wide[0], wide[2])), 1e-9)
    origin = np.array([np.interp(places[0], at, line[:, 0]), treads[0], np.interp(places[0], at, line[:, 2])])
    made = Flight(
        float(places[0]),
        float(places[-1]),
        origin,
        direction,
        places - places[0],
        np.array(treads),
        np.zeros((1, 1)),
    )
    return replace(made, ground=_raster(made, triangles))


def _raster(flight: Flight, triangles: np.ndarray) -> np.ndarray:
    """Return Flight.ground."""
    rows = np.arange(-MARGIN, flight.length + MARGIN + CELL, CELL)
    lanes = np.arange(-ASIDE, ASIDE + LANE / 2, LANE)
    expected = flight.treads[np.searchsorted(flight.risers, rows)]
    middle = flight.origin + rows[:, None] * flight.direction
    middle[:, 1] = expected
    # Beside the path risers may lie elsewhere, but never by more than a tread.
    return np.stack([surface(triangles, middle + lane * flight.left) for lane in lanes], -1)
