"""Runs of frames in which a condition holds."""

from __future__ import annotations

import numpy as np


def runs(mask: np.ndarray, shortest: int = 3, gap: int = 2) -> list[tuple[int, int]]:
    """Return the runs (first, last + 1) of a boolean mask (T,).

    Gaps of up to ``gap`` frames are closed; runs of fewer than ``shortest`` frames are dropped.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    found: list[list[int]] = []
    for start, stop in edges.reshape(-1, 2):
        if found and start - found[-1][1] <= gap:
            found[-1][1] = int(stop)
        else:
            found.append([int(start), int(stop)])
    return [(a, b) for a, b in found if b - a >= shortest]
