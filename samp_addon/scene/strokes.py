"""Lines drawn on a floor as way-points: few of them, close to the line. Metres, any axes."""

from __future__ import annotations

import numpy as np

TOLERANCE = 0.12
"""Metres that the line may pass beside the straight ways between its way-points."""

SPACING = 0.4
"""Least metres between two way-points; closer ones would make a walker turn on the spot."""

MOST = 60
"""Way-points of one line."""


def waypoints(line: np.ndarray, tolerance: float = TOLERANCE, spacing: float = SPACING) -> np.ndarray:
    """Return the way-points (K, 3) of a line (N, 3), its two ends among them; none for a line without points."""
    line = np.asarray(line, float).reshape(-1, 3)
    line = line[np.isfinite(line).all(1)]
    if len(line) < 2:
        return line
    while True:
        found = line[_corners(line, tolerance)]
        found = _spaced(found, spacing)
        if len(found) <= MOST:
            return found
        tolerance *= 1.5


def _corners(line: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the flags (N,) of the points that are kept, by Ramer, Douglas and Peucker."""
    kept = np.zeros(len(line), dtype=bool)
    kept[[0, -1]] = True
    waiting = [(0, len(line) - 1)]
    while waiting:
        first, last = waiting.pop()
        if last - first < 2:
            continue
        away = _from_segment(line[first + 1 : last], line[first], line[last])
        farthest = int(away.argmax())
        if away[farthest] > tolerance:
            middle = first + 1 + farthest
            kept[middle] = True
            waiting += [(first, middle), (middle, last)]
    return kept


def _from_segment(points: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the distances (N,) of points from the segment between a and b."""
    along = b - a
    share = np.clip((points - a) @ along / max(float(along @ along), 1e-12), 0, 1)
    return np.linalg.norm(points - a - share[:, None] * along, axis=-1)


def _spaced(points: np.ndarray, spacing: float) -> np.ndarray:
    """Return the points without those that are closer than ``spacing`` to the one kept before; the last one stays."""
    kept = [points[0]]
    for point in points[1:-1]:
        if np.linalg.norm(point - kept[-1]) >= spacing and np.linalg.norm(point - points[-1]) >= spacing:
            kept.append(point)
    return np.array([*kept, points[-1]])
