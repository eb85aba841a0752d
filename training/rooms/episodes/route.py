"""Routes on the floor: navmesh paths with rounded corners, sampled uniformly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

STEP = 0.02  # metres between the samples of a route
ROUND = 0.16  # sigma (m) of the smoothing that rounds corners


@dataclass(frozen=True)
class Route:
    """A route. points: (K, 2) x and z, metres, STEP apart. tangent: (K,) yaw along the route, radians, unwrapped.

    end_yaw: yaw of the body at the end, radians. pace: m/s.
    """

    points: np.ndarray
    tangent: np.ndarray
    end_yaw: float
    pace: float

    @property
    def length(self) -> float:
        """Length of the route, metres."""
        return (len(self.points) - 1) * STEP


def rounded(corners: np.ndarray, end_yaw: float, pace: float) -> Route:
    """Return the route along corners (N, 2), metres, at least one; both ends stay in place."""
    corners = np.asarray(corners, dtype=np.float64)
    away = np.linalg.norm(np.diff(corners, axis=0), axis=-1)
    corners = corners[np.concatenate([[True], away > 1e-6])]
    if len(corners) < 2:
        return Route(corners[:1], np.array([end_yaw]), end_yaw, pace)
    dense = _even(corners)
    sigma = ROUND / STEP
    # Point reflection at both ends keeps them in place.
    pad = min(int(4 * sigma), len(dense) - 1)
    front, back = 2 * dense[0] - dense[pad:0:-1], 2 * dense[-1] - dense[-2 : -pad - 2 : -1]
    smooth = gaussian_filter1d(np.concatenate([front, dense, back]), sigma, axis=0, mode="nearest")
    points = _even(smooth[pad : pad + len(dense)])
    tangent = (
        np.unwrap(np.arctan2(*np.gradient(points, axis=0).T)) if len(points) > 1 else np.array([end_yaw])
    )
    return Route(points, tangent, end_yaw, pace)


def _even(line: np.ndarray) -> np.ndarray:
    """Return points (K, 2) about STEP apart along a line (N, 2), including its ends."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=-1))])
    at = np.linspace(0.0, along[-1], max(int(round(along[-1] / STEP)), 1) + 1)
    return np.column_stack([np.interp(at, along, line[:, k]) for k in range(2)])
