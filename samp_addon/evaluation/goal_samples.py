"""Metrics of GoalNet (SAMP, section 5.2): reconstruction errors and diversity of goals.

Positions are in metres and their metrics in centimetres; metrics of directions are in degrees.
"""

from __future__ import annotations

import numpy as np


def position_error(predicted: np.ndarray, true: np.ndarray) -> float:
    """Return the mean distance between positions (N, 3) and (N, 3), cm."""
    return float(100 * np.linalg.norm(predicted - true, axis=-1).mean())


def direction_error(predicted: np.ndarray, true: np.ndarray) -> float:
    """Return the mean angle between vectors (N, 3) and (N, 3) of any length, degrees."""
    return float(np.degrees(_angles(predicted, true)).mean())


def apd_position(positions: np.ndarray) -> float:
    """Return APD-Pos (equation 7), cm: mean distance between the N goals of an object, over L objects, (L, N, 3)."""
    gaps = np.linalg.norm(positions[:, :, None] - positions[:, None], axis=-1)
    return float(100 * _mean_of_pairs(gaps))


def apd_direction(directions: np.ndarray) -> float:
    """Return APD-Rot (equation 8), degrees: mean angle between N directions of an object, over L objects, (L, N, 3)."""
    return float(np.degrees(_mean_of_pairs(_angles(directions[:, :, None], directions[:, None]))))


def _mean_of_pairs(table: np.ndarray) -> float:
    """Return the mean over objects and ordered pairs of different goals of a table (L, N, N) with zero diagonal."""
    objects, goals = table.shape[:2]
    return float(table.sum() / (objects * goals * (goals - 1)))


def _angles(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return angles (...) between vectors (..., 3), radians."""
    a = a / np.maximum(np.linalg.norm(a, axis=-1, keepdims=True), 1e-12)
    b = b / np.maximum(np.linalg.norm(b, axis=-1, keepdims=True), 1e-12)
    # By the chord length: the arc cosine of the dot product is inaccurate for small angles.
    return 2 * np.arcsin(np.clip(np.linalg.norm(a - b, axis=-1) / 2, 0, 1))
