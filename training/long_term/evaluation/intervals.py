"""Means with 95 % intervals; rooms are the units of resampling."""

from __future__ import annotations

import numpy as np

DRAWS = 1000


def mean(values: np.ndarray, rooms: np.ndarray, seed: int = 0) -> tuple[float, float, float]:
    """Return the mean of values (N,) and the 2.5th and 97.5th percentile under resampling of their rooms (N,)."""
    values, rooms = np.asarray(values, float), np.asarray(rooms)
    units, index = np.unique(rooms, return_inverse=True)
    sums, counts = np.bincount(index, values), np.bincount(index)
    rng = np.random.default_rng(seed)
    chosen = rng.integers(0, len(units), (DRAWS, len(units)))
    draws = sums[chosen].sum(1) / counts[chosen].sum(1)
    low, high = np.percentile(draws, [2.5, 97.5])
    return float(values.mean()), float(low), float(high)
