"""Curves by which corrections fade in and out."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

SETTLED = 16  # frames at the end of a take in which a settled body rests, half a second


def smoothstep(t: np.ndarray) -> np.ndarray:
    """Return 0 up to t = 0 and 1 from t = 1, with zero slope at both ends."""
    t = np.clip(t, 0.0, 1.0)
    return t * t * (3 - 2 * t)


def anticipate(values: np.ndarray, window: int, sigma: float) -> np.ndarray:
    """Let corrections (T,) begin before they are needed.

    Return their maximum over a window of ``window`` frames, smoothed by a Gaussian of ``sigma`` frames.
    """
    return gaussian_filter1d(maximum_filter1d(values, window), sigma, mode="nearest")


def settling(count: int, down: int, duration: float, early: int) -> np.ndarray:
    """Return weights (count,) that rise from 0 to 1 over ``duration`` frames, at most until SETTLED before the last.

    down: frame at which a body is down on its seat. early: frames before it at which the weights begin to rise.
    """
    duration = min(duration, count - down + early - SETTLED)
    return smoothstep((np.arange(count) - down + early) / duration)
