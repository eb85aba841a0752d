"""One bone's rotation channels in whatever rotation mode the artist left it, to and from quaternions."""

from __future__ import annotations

import numpy as np
from mathutils import Euler, Quaternion

from ... import rotation

_PATHS = {"QUATERNION": ("rotation_quaternion", 4), "AXIS_ANGLE": ("rotation_axis_angle", 4)}


def rotation_channel(mode: str) -> tuple[str, int]:
    """The property that holds the rotation in this mode, and how many numbers it has."""
    return _PATHS.get(mode, ("rotation_euler", 3))


def rest_values(path: str, size: int) -> tuple[float, ...]:
    """What a channel holds in the rest pose."""
    if path == "scale":
        return (1.0,) * size
    if path == "rotation_quaternion":
        return (1.0, 0.0, 0.0, 0.0)
    return (0.0, 0.0, 1.0, 0.0) if path == "rotation_axis_angle" else (0.0,) * size


def from_quaternions(mode: str, quaternions: np.ndarray) -> np.ndarray:
    """Channel values (T, 3 or 4) of unit quaternions (T, 4), without jumps from frame to frame."""
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


def near(mode: str, quaternions: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Channel values (T, 3 or 4) of unit quaternions (T, 4): of all that mean the same those next to ``values``."""
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
    """Unit quaternions (T, 4) of channel values (T, 3 or 4)."""
    if mode == "QUATERNION":
        return rotation.normalise(values)
    if mode == "AXIS_ANGLE":
        axes = values[:, 1:] / np.maximum(np.linalg.norm(values[:, 1:], axis=1, keepdims=True), 1e-12)
        return rotation.from_axis_angle(values[:, :1] * axes)
    return np.array([Euler(v, mode).to_quaternion() for v in values], dtype=np.float64)
