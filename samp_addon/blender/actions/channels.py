"""Rotation channels of a bone, in any rotation mode, to and from quaternions."""

from __future__ import annotations

import numpy as np
from mathutils import Euler, Quaternion

from ... import rotation

_PATHS = {"QUATERNION": ("rotation_quaternion", 4), "AXIS_ANGLE": ("rotation_axis_angle", 4)}


def rotation_channel(mode: str) -> tuple[str, int]:
    """Return the property that holds the rotation in this mode, and its size."""
    return _PATHS.get(mode, ("rotation_euler", 3))


def rest_values(path: str, size: int) -> tuple[float, ...]:
    """Return the values of a channel in the rest pose."""
    if path == "scale":
        return (1.0,) * size
    if path == "rotation_quaternion":
        return (1.0, 0.0, 0.0, 0.0)
    return (0.0, 0.0, 1.0, 0.0) if path == "rotation_axis_angle" else (0.0,) * size


def from_quaternions(mode: str, quaternions: np.ndarray) -> np.ndarray:
    """Convert unit quaternions (T, 4) to channel values (T, 3 or 4) that are continuous over time."""
    continuous = rotation.continuous(quaternions)
    if continuous[0, 0] < 0:
        continuous = -continuous
    if mode == "QUATERNION":
        return continuous
    if mode == "AXIS_ANGLE":
        vectors = rotation.to_axis_angle(quaternions)
        angles = np.linalg.norm(vectors, axis=1, keepdims=True)
        axes = np.where(angles > 1e-9, vectors / np.maximum(angles, 1e-12), [0.0, 1.0, 0.0])
        return np.concatenate([angles, axes], axis=1)
    values, last = np.empty((len(continuous), 3)), None
    for t, q in enumerate(continuous):
        last = Quaternion(q).to_euler(mode, last) if last is not None else Quaternion(q).to_euler(mode)
        values[t] = last
    return values


def nearest(mode: str, quaternions: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Convert unit quaternions (T, 4) to the equivalent channel values (T, 3 or 4) nearest to ``values``."""
    if mode == "QUATERNION":
        return quaternions * np.where(np.sum(quaternions * values, axis=1, keepdims=True) < 0, -1.0, 1.0)
    if mode == "AXIS_ANGLE":
        own = from_quaternions(mode, quaternions)
        own *= np.where(np.sum(own[:, 1:] * values[:, 1:], axis=1, keepdims=True) < 0, -1.0, 1.0)
        own[:, 0] += 2 * np.pi * np.round((values[:, 0] - own[:, 0]) / (2 * np.pi))
        return own
    pairs = zip(quaternions, values, strict=True)
    return np.array([Quaternion(q).to_euler(mode, Euler(v, mode)) for q, v in pairs], dtype=np.float64)


def to_quaternions(mode: str, values: np.ndarray) -> np.ndarray:
    """Convert channel values (T, 3 or 4) to unit quaternions (T, 4)."""
    if mode == "QUATERNION":
        return rotation.normalise(values)
    if mode == "AXIS_ANGLE":
        axes = values[:, 1:] / np.maximum(np.linalg.norm(values[:, 1:], axis=1, keepdims=True), 1e-12)
        return rotation.from_axis_angle(values[:, :1] * axes)
    return np.array([Euler(v, mode).to_quaternion() for v in values], dtype=np.float64)
