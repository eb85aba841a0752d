"""How much drawn windows differ from captured motion: in the distance that a body covers, and in sliding of both feet.

From a standing start the networks seldom set off, and in their walks both feet often slide at once.
"""

from __future__ import annotations

import numpy as np

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

SLIDES = 0.3
"""Metres that the slower foot moves for each metre of the pelvis, up to which sliding costs nothing; captured: 0.14."""


def wanted(speed: float, share: float) -> float:
    """Return the distance, metres, that a share of captured bodies do not exceed. speed: of the pelvis at the start,
    metres per second."""
    row = WAYS[int(np.searchsorted(SPEEDS, speed, side="right"))]
    return float(np.interp(share, SHARES, row))


def unlike(feet: np.ndarray, roots: np.ndarray, far: float) -> np.ndarray:
    """Return the cost (B,) of windows, metres: the difference of the distance covered from ``far``, and the way of the
    slower foot beyond SLIDES.

    feet: (B, T, 2, 3) of both feet. roots: (B, T, 3) of the pelvis. far: metres.
    """
    gone = np.linalg.norm((roots[:, -1] - roots[:, 0])[:, [0, 2]], axis=-1)
    slid = np.linalg.norm(np.diff(feet, axis=1), axis=-1).min(-1).sum(-1)
    return np.abs(gone - far) + np.maximum(slid - SLIDES * gone, 0.0)
