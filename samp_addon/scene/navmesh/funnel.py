"""String pulling: the shortest polyline through a sequence of portals (funnel algorithm), in the ground plane."""

from __future__ import annotations

import numpy as np


def pull(start: np.ndarray, goal: np.ndarray, left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return corners (K, 2) of the shortest polyline from start (2,) to goal (2,) through portals left, right (Q, 2).

    Left is the side of positive rotation, from the first axis to the second; see `left_and_right`. Start and goal are
    the first and last corner.
    """
    lefts, rights = [*left.tolist(), goal.tolist()], [*right.tolist(), goal.tolist()]
    corners = [start.tolist()]
    apex, l_side, r_side = corners[0], corners[0], corners[0]
    at = l_at = r_at = 0
    while at < len(lefts):
        new_left, new_right = lefts[at], rights[at]
        if _turn(apex, r_side, new_right) >= 0:
            if _same(apex, r_side) or _turn(apex, l_side, new_right) < 0:
                r_side, r_at = new_right, at
            else:
                apex, at = l_side, l_at + 1
                corners.append(apex)
                l_side, r_side, r_at = apex, apex, l_at
                continue
        if _turn(apex, l_side, new_left) <= 0:
            if _same(apex, l_side) or _turn(apex, r_side, new_left) > 0:
                l_side, l_at = new_left, at
            else:
                apex, at = r_side, r_at + 1
                corners.append(apex)
                l_side, r_side, l_at = apex, apex, r_at
                continue
        at += 1
    corners.append(goal.tolist())
    points = np.array(corners)
    moved = np.append(True, np.abs(np.diff(points, axis=0)).max(axis=1) > 1e-9)
    return points[moved] if moved.sum() > 1 else points[[0, -1]]


def left_and_right(ends: np.ndarray, forward: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sort the ends (Q, 2, 2) of portals into left and right (Q, 2) with respect to directions forward (Q, 2)."""
    across = ends[:, 1] - ends[:, 0]
    swap = (forward[:, 0] * across[:, 1] - forward[:, 1] * across[:, 0] > 0)[:, None]
    return np.where(swap, ends[:, 1], ends[:, 0]), np.where(swap, ends[:, 0], ends[:, 1])


def _turn(a: list[float], b: list[float], c: list[float]) -> float:
    """Return twice the signed area of a, b, c; positive if c is to the left of the line from a to b."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _same(a: list[float], b: list[float]) -> bool:
    return abs(a[0] - b[0]) < 1e-9 and abs(a[1] - b[1]) < 1e-9
