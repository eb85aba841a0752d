"""How deep bodies are in each other, from balls inside their skins (body/balls.py). Network frame, metres."""

from __future__ import annotations

import numpy as np

from ..body.balls import Track

CHUNK = 400_000
"""Pairs of frames times balls that are compared at once."""


def depth(a: Track, b: Track, frames_a: np.ndarray, frames_b: np.ndarray) -> np.ndarray:
    """Return how deep the bodies are in each other (N,), metres, for pairs of frames (N,) of each; negative values are
    the distance between them."""
    found = np.full(len(frames_a), -np.inf)
    limit = (a.radii[:, None] + b.radii[None]).astype(np.float32)
    step = max(1, CHUNK // limit.size)
    for begin in range(0, len(frames_a), step):
        part = slice(begin, begin + step)
        one, two = a.centres[frames_a[part]], b.centres[frames_b[part]]
        origin = one.mean(1, keepdims=True)  # near the bodies, single precision is exact enough
        one, two = (one - origin).astype(np.float32), (two - origin).astype(np.float32)
        squared = (one**2).sum(-1)[:, :, None] + (two**2).sum(-1)[:, None] - 2 * one @ two.transpose(0, 2, 1)
        found[part] = (limit - np.sqrt(np.maximum(squared, 0))).max((1, 2))
    return found


def over_time(a: Track, b: Track) -> np.ndarray:
    """Return how deep two bodies are in each other in each frame (T,) of the longer one; a body keeps its last pose.

    Frames in which they are far from each other are minus infinity.
    """
    count = max(len(a), len(b))
    rows_a, rows_b = np.minimum(np.arange(count), len(a) - 1), np.minimum(np.arange(count), len(b) - 1)
    (centre_a, reach_a), (centre_b, reach_b) = a.bounds(), b.bounds()
    apart = np.linalg.norm(centre_a[rows_a] - centre_b[rows_b], axis=-1) - reach_a[rows_a] - reach_b[rows_b]
    near, found = np.flatnonzero(apart < 0), np.full(count, -np.inf)
    found[near] = depth(a, b, rows_a[near], rows_b[near])
    return found


def conflicts(a: Track, b: Track, clearance: float) -> np.ndarray:
    """Return (Ta, Tb) flags of the pairs of frames in which the bodies are nearer than ``clearance`` metres, and of the
    pairs next to these, between which nothing is known."""
    (centre_a, reach_a), (centre_b, reach_b) = a.bounds(), b.bounds()
    apart = np.linalg.norm(centre_a[:, None] - centre_b[None], axis=-1)
    near = np.nonzero(apart < reach_a[:, None] + reach_b[None] + clearance)
    flags = np.zeros((len(a), len(b)), dtype=bool)
    flags[near] = depth(a, b, *near) > -clearance
    return _grown(flags)


def _grown(flags: np.ndarray) -> np.ndarray:
    """Return the flags (T, U), each spread to its eight neighbours."""
    rows = flags.copy()
    rows[1:] |= flags[:-1]
    rows[:-1] |= flags[1:]
    grown = rows.copy()
    grown[:, 1:] |= rows[:, :-1]
    grown[:, :-1] |= rows[:, 1:]
    return grown
