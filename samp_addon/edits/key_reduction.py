"""Fewer keys for a channel: cubic pieces between kept keys, within a bound on the error in every frame.

A piece between two keys is a cubic Hermite curve in the channel's own numbers, with the slopes of the least squares.
Blender's Bezier curves with handles at a third of the interval reproduce it exactly. The slopes before and after a key
differ a little: with equal ones, half as many keys can be left out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .. import rotation

Error = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Return the errors (M,) of values (M, n) against true values (M, n)."""

LONGEST = 240
"""Frames of the longest piece."""


@dataclass(frozen=True)
class Keys:
    """Kept keys of a channel.

    frames: (K,) indices of frames, the first and the last included; a single one for a channel that does not move.
    slopes: (K - 1, 2, n) of each piece at its first and at its last key, values per frame.
    """

    frames: np.ndarray
    slopes: np.ndarray


def reduced(values: np.ndarray, error: Error, bound: float) -> Keys:
    """Return keys with which a channel stays within a bound in every frame.

    values: (T, n), one row for each frame. error: measures rows against the true ones. bound: its largest value.
    """
    count = len(values)
    if count < 2 or error(np.repeat(values[:1], count, 0), values).max() <= bound:
        return Keys(np.zeros(1, int), np.zeros((0, 2, values.shape[1])))
    frames, slopes = [0], []
    while frames[-1] < count - 1:
        last, found = _longest_piece(values, frames[-1], error, bound)
        frames.append(last)
        slopes.append(found)
    return Keys(np.array(frames), np.array(slopes))


def interpolated(values: np.ndarray, keys: Keys) -> np.ndarray:
    """Return the channel (T, n) that keys give; values: (T, n), of which those at the keys are read."""
    if len(keys.frames) == 1:
        return np.repeat(values[keys.frames], len(values), 0)
    parts = [values[:1]]
    for first, last, slopes in zip(keys.frames[:-1], keys.frames[1:], keys.slopes, strict=True):
        start, end = _basis(last - first)
        parts += [start @ values[[first, last]] + end @ slopes, values[last : last + 1]]
    return np.concatenate(parts)


def angle_error(made: np.ndarray, true: np.ndarray) -> np.ndarray:
    """Return the angles (M,), radians, between quaternions (M, 4), of which ``made`` may have any length."""
    made = rotation.normalise(made)
    return 4 * np.arcsin(np.minimum(np.linalg.norm(made - true, axis=-1) / 2, 1.0))


def distance_error(made: np.ndarray, true: np.ndarray) -> np.ndarray:
    """Return the distances (M,) between points (M, n)."""
    return np.linalg.norm(made - true, axis=-1)


def _longest_piece(values: np.ndarray, first: int, error: Error, bound: float) -> tuple[int, np.ndarray]:
    """Return the last frame to which one piece from ``first`` stays within the bound, and its slopes (2, n)."""
    most = min(len(values) - 1, first + LONGEST)

    def slopes_to(last: int) -> np.ndarray | None:
        made, slopes = _fitted(values[first : last + 1])
        within = not len(made) or error(made, values[first + 1 : last]).max() <= bound
        return slopes if within else None

    # Doubling, then bisection: whether a piece fits is nearly monotone in its length.
    # A cubic goes through any four values.
    good, step = min(first + 3, most), 3
    slopes = slopes_to(good)
    if slopes is None:
        good = min(first + 2, most)
        slopes = _fitted(values[first : good + 1])[1]
    while good < most:
        found = slopes_to(min(first + step, most))
        if found is None:
            break
        good, step, slopes = min(first + step, most), step * 2, found
    high = min(first + step, most)
    while high - good > 1:
        middle = (good + high) // 2
        found = slopes_to(middle)
        if found is None:
            high = middle
        else:
            good, slopes = middle, found
    return good, slopes


def _fitted(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the inner values (N - 2, n) of the piece nearest to values (N, n) that it begins and ends with, and its
    slopes (2, n)."""
    ends = values[[0, -1]]
    if len(values) == 2:
        return values[:0], np.repeat(values[1:] - values[:1], 2, 0)
    start, end = _basis(len(values) - 1)
    slopes = np.linalg.lstsq(end, values[1:-1] - start @ ends, rcond=None)[0]
    return start @ ends + end @ slopes, slopes


def _basis(length: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the weights (length - 1, 2) of the two values and (length - 1, 2) of the two slopes of a piece."""
    t = np.arange(1, length) / length
    values = np.stack([2 * t**3 - 3 * t**2 + 1, 3 * t**2 - 2 * t**3], -1)
    return values, np.stack([t**3 - 2 * t**2 + t, t**3 - t**2], -1) * length
