"""How much drawn windows differ from captured motion: in the distance covered, in sliding of both feet, in stooping.

From a standing start the networks seldom set off, in their walks both feet often slide at once, and a body that stoops
in one window stoops more in the next.
"""

from __future__ import annotations

import numpy as np

from ...skeleton import INDEX

SPEEDS = (0.05, 0.15, 0.4)
"""Bounds between four classes of starts, metres per second of the pelvis."""
SHARES = (0.0, 0.1, 0.25, 0.5, 0.6, 0.7, 0.8, 0.9, 0.98)
"""Shares of captured windows that get no farther than the distances in the columns of WAYS."""
WAYS = (
    (0.00, 0.01, 0.03, 0.16, 0.29, 0.49, 0.76, 1.15, 1.68),
    (0.00, 0.02, 0.07, 0.18, 0.33, 0.45, 0.69, 1.21, 1.71),
    (0.00, 0.07, 0.16, 0.37, 0.46, 0.65, 1.07, 1.42, 1.87),
    (0.01, 0.35, 0.67, 1.31, 1.47, 1.60, 1.79, 2.03, 2.41),
)
"""Distances that the pelvis covers in a window's 64 frames, metres: a row for each class of starts, in the order of
SPEEDS. Printed by training/scene_gan/tables/ways.py."""
ANY_WAY = (0.00, 0.05, 0.19, 0.62, 0.95, 1.26, 1.52, 1.80, 2.26)
"""The same for all starts together."""

SLIDES = 0.3
"""Metres that the slower foot moves for each metre of the pelvis, up to which sliding costs nothing; captured: 0.14."""

HEAD = 1.41
"""Height, metres, of the head over the lower foot: the 5th percentile of the means of 837 captured windows in which a
body stands or walks."""
STOOPS = 20.0
"""Metres of difference in the distance covered that a head lower by a metre weighs."""
STANDING = 0.75
"""Height, metres, of the pelvis over the lower foot, from which on a body stands or walks."""
PELVIS, BALLS, HEAD_JOINT = INDEX["pelvis"], (INDEX["left_foot"], INDEX["right_foot"]), INDEX["head"]
"""Joints: pelvis, balls of the feet, head."""


def wanted(speed: float | None, share: float) -> float:
    """Return the distance, metres, that a share of captured bodies do not exceed.

    speed: of the pelvis at the start, metres per second. None where a take begins: it begins in any moment of what
    people do, although its first pose stands. With the distances of standing starts, most takes would stand for long.
    """
    row = ANY_WAY if speed is None else WAYS[int(np.searchsorted(SPEEDS, speed, side="right"))]
    return float(np.interp(share, SHARES, row))


def unlike(joints: np.ndarray, roots: np.ndarray, far: float) -> np.ndarray:
    """Return the cost (B,) of windows, metres: the difference of the distance covered from ``far``, the way of the
    slower foot beyond SLIDES, and STOOPS times how far the head is lower than HEAD, on average.

    joints: (B, T, 22, 3), y up. roots: (B, T, 3) of the pelvis. far: metres.
    """
    gone = np.linalg.norm((roots[:, -1] - roots[:, 0])[:, [0, 2]], axis=-1)
    slid = np.linalg.norm(np.diff(joints[:, :, BALLS], axis=1), axis=-1).min(-1).sum(-1)
    return np.abs(gone - far) + np.maximum(slid - SLIDES * gone, 0.0) + STOOPS * stooping(joints).mean(-1)


def stooping(joints: np.ndarray) -> np.ndarray:
    """Return by how much the head is lower than HEAD, metres, where a body stands or walks (..., T).

    joints: (..., T, 22, 3), y up.
    """
    heights = joints[..., 1] - joints[..., BALLS, 1].min(-1, keepdims=True)
    low = np.maximum(HEAD - heights[..., HEAD_JOINT], 0.0)
    return np.where(heights[..., PELVIS] > STANDING, low, 0.0)
