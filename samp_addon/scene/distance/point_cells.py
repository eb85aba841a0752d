"""Points sorted into cells, for boxes of a few thousand among millions. Metres."""

from __future__ import annotations

import numpy as np

EDGE = 0.2
"""Metres along the edge of a cell."""


class PointCells:
    """Points (N, 3) that do not move."""

    def __init__(self, points: np.ndarray, edge: float = EDGE) -> None:
        self._edge = edge
        cells = np.floor(points / edge).astype(np.int64)
        self._low = cells.min(0, initial=0) if len(points) else np.zeros(3, np.int64)
        self._shape = (cells.max(0) - self._low + 1) if len(points) else np.zeros(3, np.int64)
        keys = self._keys(*(cells - self._low).T)
        self._order = np.argsort(keys, kind="stable")
        self._keys_in_order = keys[self._order]
        self._first = np.flatnonzero(np.r_[True, np.diff(self._keys_in_order) > 0][: len(keys)])
        self._count = np.diff(np.append(self._first, len(keys)))
        occupied = cells[self._order[self._first]] if len(keys) else np.zeros((0, 3))
        self.centres = (occupied + 0.5) * edge
        """(C, 3) of the cells that hold points."""
        self.radius = edge * float(np.sqrt(3)) / 2
        """Metres from the centre of a cell within which its points are."""

    def members(self, chosen: np.ndarray) -> np.ndarray:
        """Return the indices of the points in the cells (C,) that are flagged."""
        rows = np.flatnonzero(chosen)
        count = self._count[rows]
        start = np.repeat(self._first[rows] - np.cumsum(count) + count, count)
        return self._order[start + np.arange(count.sum())]

    def within(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Return the indices of at least all points in the box from low to high (3,): those of the cells it touches."""
        first = np.maximum(np.floor(low / self._edge).astype(np.int64) - self._low, 0)
        last = np.minimum(np.floor(high / self._edge).astype(np.int64) - self._low, self._shape - 1)
        if (first > last).any():
            return np.zeros(0, np.int64)
        x, y = (a.ravel() for a in np.meshgrid(*(np.arange(first[k], last[k] + 1) for k in (0, 1))))
        # The cells of a column along z are neighbours in the order.
        begin = np.searchsorted(self._keys_in_order, self._keys(x, y, first[2]))
        end = np.searchsorted(self._keys_in_order, self._keys(x, y, last[2]), side="right")
        return self._order[np.concatenate([np.arange(a, b) for a, b in zip(begin, end, strict=True)])]

    def _keys(self, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        return (x * self._shape[1] + y) * self._shape[2] + z
