"""GoalNet's measures (section 5.2 of the paper): reconstruction errors and the diversity of goals.

Positions in metres go in, centimetres come out; directions are unit vectors, degrees come out.
"""

from __future__ import annotations

import numpy as np


def position_error(predicted: np.ndarray, true: np.ndarray) -> float:
    """Mean distance in cm between positions (N, 3) and (N, 3)."""
    return float(100 * np.linalg.norm(predicted - true, axis=-1).mean())


def direction_error(predicted: np.ndarray, true: np.ndarray) -> float:
    """Mean angle in degrees between directions (N, 3) and (N, 3) of any length."""
    return float(np.degrees(_angles(predicted, true)).mean())


def apd_position(positions: np.ndarray) -> float:
    """APD-Pos (equation 7) in cm: mean distance between the N goals of an object, over L objects; (L, N, 3)."""
    gaps = np.linalg.norm(positions[:, :, None] - positions[:, None], axis=-1)
    return float(100 * _mean_of_pairs(gaps))


def apd_direction(directions: np.ndarray) -> float:
    """APD-Rot (equation 8) in degrees: the same for the angles between directions (L, N, 3)."""
    return float(np.degrees(_mean_of_pairs(_angles(directions[:, :, None], directions[:, None]))))


def _mean_of_pairs(table: np.ndarray) -> float:
    """Mean over objects and over ordered pairs of different goals of a table (L, N, N) with a zero diagonal."""
    objects, goals = table.shape[:2]
    return float(table.sum() / (objects * goals * (goals - 1)))


def _angles(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    a = a / np.maximum(np.linalg.norm(a, axis=-1, keepdims=True), 1e-12)
    b = b / np.maximum(np.linalg.norm(b, axis=-1, keepdims=True), 1e-12)
    # From the chord: the arc cosine of the dot product loses small angles to rounding.
    return 2 * np.arcsin(np.clip(np.linalg.norm(a - b, axis=-1) / 2, 0, 1))
