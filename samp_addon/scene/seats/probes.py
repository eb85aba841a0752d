"""Measurements of a SupportMap around bodies: shares of a part that are supported or blocked, distances to edges.

Places are x and z (N, 2) in the map's rotated frame, yaws (N,) are relative to it. Parts are points (P, 2) of the body,
left and forward of the pelvis, metres.
"""

from __future__ import annotations

import numpy as np

from .support import SupportMap

WIDEST_STEP = 0.06
"""Metres between a supporting surface and the seat beside it."""


def lattice(
    across: tuple[float, float], ahead: tuple[float, float], step: float = 0.045, stride: float | None = None
) -> np.ndarray:
    """Return body-frame points (P, 2), left and forward, that fill a rectangle.

    step: spacing, metres. stride: spacing in the forward direction, if different.
    """
    n = [max(int(round((b - a) / s)) + 1, 2) for (a, b), s in ((across, step), (ahead, stride or step))]
    left, forward = np.meshgrid(np.linspace(*across, n[0]), np.linspace(*ahead, n[1]), indexing="ij")
    return np.stack([left.ravel(), forward.ravel()], axis=-1)


def at_bodies(places: np.ndarray, yaws: np.ndarray, part: np.ndarray) -> np.ndarray:
    """Return rotated-frame points (N, P, 2) of body-frame points (P, 2), left and forward."""
    sin, cos = np.sin(yaws)[:, None], np.cos(yaws)[:, None]
    left, forward = part[:, 0], part[:, 1]
    return places[:, None] + np.stack([left * cos + forward * sin, forward * cos - left * sin], axis=-1)


def share_within(
    grid: SupportMap,
    places: np.ndarray,
    yaws: np.ndarray,
    height: np.ndarray,
    part: np.ndarray,
    low: float,
    high: float,
) -> np.ndarray:
    """Return the share (N,) of a part's points whose supporting surface is between two heights relative to the seat."""
    rise = grid.height(at_bodies(places, yaws, part)) - height[:, None]
    return ((rise >= low) & (rise <= high)).mean(axis=1)


def support_share(
    grid: SupportMap,
    places: np.ndarray,
    yaws: np.ndarray,
    height: np.ndarray,
    part: np.ndarray,
    step: float = WIDEST_STEP,
) -> np.ndarray:
    """Return the share (N,) of a part's points whose supporting surface is about as high as the seat."""
    return share_within(grid, places, yaws, height, part, -step, step)


def blocked_share(
    grid: SupportMap,
    places: np.ndarray,
    yaws: np.ndarray,
    part: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
) -> np.ndarray:
    """Return the share (N,) of a part's points with something solid between two heights over the floor (N,)."""
    return grid.blocked(at_bodies(places, yaws, part), low[:, None], high[:, None]).mean(axis=1)


def lines_blocked(
    grid: SupportMap,
    places: np.ndarray,
    yaws: np.ndarray,
    part: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
) -> np.ndarray:
    """Return the share (N,) of a part's forward lines that hit something solid, which thin rails do as well."""
    hit = grid.blocked(at_bodies(places, yaws, part), low[:, None], high[:, None])
    lines = len(np.unique(part[:, 0]))
    return hit.reshape(len(places), lines, len(part) // lines).any(axis=2).mean(axis=1)


def first_hit(
    grid: SupportMap,
    places: np.ndarray,
    yaws: np.ndarray,
    ranges: np.ndarray,
    left: float,
    low: np.ndarray,
    high: np.ndarray,
) -> np.ndarray:
    """Return the distance (N,) along a ray to something solid between two heights over the floor (N,)."""
    return _first(
        grid.blocked(at_bodies(places, yaws, _ray(ranges, left)), low[:, None], high[:, None]), ranges
    )


def edge_distance(
    grid: SupportMap,
    places: np.ndarray,
    yaws: np.ndarray,
    ranges: np.ndarray,
    left: float,
    height: np.ndarray,
) -> np.ndarray:
    """Return the distance (N,) to the edge of the seat, forward along ranges or, where they are negative, backwards."""
    rise = grid.height(at_bodies(places, yaws, _ray(ranges, left))) - height[:, None]
    return _first(~(np.abs(rise) < 0.09), ranges)


def side_edge_distance(
    grid: SupportMap,
    places: np.ndarray,
    yaws: np.ndarray,
    ranges: np.ndarray,
    sign: int,
    height: np.ndarray,
) -> np.ndarray:
    """Return the distance (N,) to the edge of the seat on one side, measured at the middle of the thighs."""
    part = np.stack([sign * ranges, np.full_like(ranges, 0.03)], axis=-1)
    rise = grid.height(at_bodies(places, yaws, part)) - height[:, None]
    return _first(~(np.abs(rise) < 0.09), ranges)


def _ray(ranges: np.ndarray, left: float) -> np.ndarray:
    return np.stack([np.full_like(ranges, left), ranges], axis=-1)


def _first(found: np.ndarray, ranges: np.ndarray) -> np.ndarray:
    """Return the distance (N,) of the first hit along a ray, or a value beyond its end."""
    distance = np.append(np.abs(ranges), np.abs(ranges[-1]) + 0.05)
    return distance[np.where(found.any(axis=1), found.argmax(axis=1), len(ranges))]
