"""Two-bone inverse kinematics of legs and arms, for all frames of a motion at once."""

from __future__ import annotations

import numpy as np

from .. import rotation, skeleton

LIMBS = {
    "left_leg": ("left_hip", "left_knee", "left_ankle"),
    "right_leg": ("right_hip", "right_knee", "right_ankle"),
    "left_arm": ("left_shoulder", "left_elbow", "left_wrist"),
    "right_arm": ("right_shoulder", "right_elbow", "right_wrist"),
}
STRETCH = 0.998  # share of the limb's length that is used: near full stretch the middle joint pops


def solve_limb(
    root: np.ndarray, rotations: np.ndarray, rest_joints: np.ndarray, limb: str, target: np.ndarray
) -> np.ndarray:
    """Return local rotations (T, J, 4) that bring the end of a limb to target (T, 3).

    root: (T, 3) of the pelvis; rest_joints: (J, 3); metres. limb: a key of LIMBS. The end joint keeps its global
    rotation, and the middle joint its plane. A target out of reach is approached as far as the limb allows.
    """
    a, b, c = (skeleton.INDEX[name] for name in LIMBS[limb])
    positions, globals_ = skeleton.forward_kinematics(root, rotations, rest_joints)
    upper = np.linalg.norm(rest_joints[b] - rest_joints[a])
    lower = np.linalg.norm(rest_joints[c] - rest_joints[b])
    start, old_middle, old_end = positions[:, a], positions[:, b], positions[:, c]
    away = target - start
    distance = np.linalg.norm(away, axis=-1, keepdims=True)
    reach = np.clip(distance, abs(upper - lower) + 0.02, STRETCH * (upper + lower))
    axis = away / np.maximum(distance, 1e-9)
    middle = start + _bend(axis, reach, upper, lower, old_middle - start, old_end - start)
    turn_upper = rotation.between(old_middle - start, middle - start)
    new_upper = rotation.multiply(turn_upper, globals_[:, a])
    lower_before = rotation.rotate(turn_upper, old_end - old_middle)
    turn_lower = rotation.between(lower_before, start + axis * reach - middle)
    new_lower = rotation.multiply(turn_lower, rotation.multiply(turn_upper, globals_[:, b]))
    globals_ = globals_.copy()
    keep_end = globals_[:, c].copy()
    parent = globals_[:, skeleton.PARENTS[a]]
    out = rotations.copy()
    out[:, a] = rotation.multiply(rotation.conjugate(parent), new_upper)
    out[:, b] = rotation.multiply(rotation.conjugate(new_upper), new_lower)
    out[:, c] = rotation.multiply(rotation.conjugate(new_lower), keep_end)
    return out


def at_height(bone: np.ndarray, height: np.ndarray, flat: np.ndarray) -> np.ndarray:
    """Return bones (T, 3), of unchanged length, that rise by height (T,), metres, and point horizontally along flat
    (T, 2)."""
    room = np.sqrt(np.maximum(np.linalg.norm(bone, axis=-1) ** 2 - height**2, 0.0))
    flat = flat * (room / np.maximum(np.linalg.norm(flat, axis=-1), 1e-6))[:, None]
    return np.stack([flat[:, 0], height, flat[:, 1]], -1)


def _bend(
    axis: np.ndarray,
    reach: np.ndarray,
    upper: float,
    lower: float,
    old_middle: np.ndarray,
    old_end: np.ndarray,
) -> np.ndarray:
    """Return the middle joint (T, 3) relative to the start of the limb, on the same side of the axis as before."""
    cosine = np.clip((upper**2 + reach**2 - lower**2) / (2 * upper * reach), -1, 1)
    swing = rotation.between(old_end, axis)
    side = rotation.rotate(swing, old_middle)
    side = side - np.sum(side * axis, -1, keepdims=True) * axis
    side = side / np.maximum(np.linalg.norm(side, axis=-1, keepdims=True), 1e-9)
    return upper * (cosine * axis + np.sqrt(1 - cosine**2) * side)
