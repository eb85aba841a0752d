"""How corrections fade in and out."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d


def smoothstep(t: np.ndarray) -> np.ndarray:
    """0 up to t = 0, 1 from t = 1, with no velocity at either end."""
    t = np.clip(t, 0.0, 1.0)
    return t * t * (3 - 2 * t)


def early(values: np.ndarray, sooner: int, evenly: float) -> np.ndarray:
    """Corrections (T,) that set in before they are needed: their maximum over a window of ``sooner`` frames, smoothed
    over ``evenly`` frames (standard deviation)."""
    return gaussian_filter1d(maximum_filter1d(values, sooner), evenly, mode="nearest")
