"""How much draws are like captured motion: bodies go as far as captured ones, and stand on one foot meanwhile.

From a standing start the networks seldom set off, and when they walk, both feet often slide.
"""

from __future__ import annotations

import numpy as np

SPEEDS = (0.05, 0.15, 0.4)
"""Metres per second of the pelvis between which starts are told apart."""
SHARES = (0.0, 0.1, 0.25, 0.5, 0.6, 0.7, 0.8, 0.9, 0.98)
"""Shares of captured windows that get no farther than a row of WAYS says."""
WAYS = (
    (0.00, 0.01, 0.03, 0.16, 0.29, 0.49, 0.76, 1.15, 1.68),
    (0.00, 0.02, 0.07, 0.18, 0.33, 0.45, 0.69, 1.21, 1.71),
    (0.00, 0.07, 0.16, 0.37, 0.46, 0.65, 1.07, 1.42, 1.87),
    (0.01, 0.35, 0.67, 1.31, 1.47, 1.60, 1.79, 2.03, 2.41),
)
"""Metres of the pelvis over a window's 64 frames, for starts slower than each of SPEEDS and for faster ones
(training/scene_gan/tables/ways.py)."""

SLIDES = 0.3
"""Metres of the slower foot for each one of the pelvis up to which a walk counts as sound; of captured ones, 0.14."""


def wanted(speed: float, share: float) -> float:
    """Return how far a body goes that begins at a speed, metres per second, and gets farther than a share of captured
    ones."""
    row = WAYS[int(np.searchsorted(SPEEDS, speed, side="right"))]
    return float(np.interp(share, SHARES, row))


def unlike(feet: np.ndarray, roots: np.ndarray, far: float) -> np.ndarray:
    """Return how far windows are from what is wanted (B,), metres: the difference from ``far``, and the way over which
    the slower foot slides beyond SLIDES.

    feet: (B, T, 2, 3). roots: (B, T, 3) of the pelvis.
    """
    gone = np.linalg.norm((roots[:, -1] - roots[:, 0])[:, [0, 2]], axis=-1)
    slid = np.linalg.norm(np.diff(feet, axis=1), axis=-1).min(-1).sum(-1)
    return np.abs(gone - far) + np.maximum(slid - SLIDES * gone, 0.0)
