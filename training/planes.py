"""Encode integers over time as byte planes that compress well, for packed training sets."""

from __future__ import annotations

import numpy as np


def encoded(values: np.ndarray) -> np.ndarray:
    """Encode unsigned integers (N, C) as bytes: second differences in time by channel, low bytes first."""
    for _ in range(2):
        values = np.diff(values, axis=0, prepend=np.zeros_like(values[:1]))
    planes = values.T.copy().view(np.uint8).reshape(values.shape[1], len(values), -1)
    return np.moveaxis(planes, 2, 0).ravel()


def decoded(planes: np.ndarray, count: int, dtype: type) -> np.ndarray:
    """Decode the output of `encoded` into signed integers (count, C)."""
    size = np.dtype(dtype).itemsize
    planes = np.moveaxis(planes.reshape(size, -1, count), 0, 2)
    unsigned = np.dtype(f"u{size}")
    values = np.ascontiguousarray(planes).view(unsigned)[..., 0].T
    for _ in range(2):
        values = np.cumsum(values, axis=0, dtype=unsigned)
    return values.view(dtype)
