"""Pose edits of whole motions: trunk pitched, pelvis moved, feet kept in place."""

from __future__ import annotations

import numpy as np

from ....samp_addon import rotation, skeleton
from ....samp_addon.refine.inverse_kinematics import solve_limb

REST = skeleton.default_rest_joints()
SPINE = {"spine1": 0.4, "spine2": 0.35, "spine3": 0.25}
GAZE = {"neck": 0.4, "head": 0.4}  # share of the trunk's pitch that neck and head compensate


def pitched(rotations: np.ndarray, joint: str, angle: np.ndarray) -> np.ndarray:
    """Return the rotations (T, J, 4) with a joint bent forward about its own lateral axis by angle (T,)
    radians."""
    j = skeleton.INDEX[joint]
    half = np.asarray(angle) / 2
    zero = np.zeros_like(half)
    bend = np.stack([np.cos(half), np.sin(half), zero, zero], -1)
    out = rotations.copy()
    out[:, j] = rotation.multiply(out[:, j], bend)
    return out


def bent_aside(rotations: np.ndarray, joint: str, angle: np.ndarray) -> np.ndarray:
    """Return the rotations (T, J, 4) with a joint bent to the right about its own front axis by angle (T,)
    radians."""
    j = skeleton.INDEX[joint]
    half = np.asarray(angle) / 2
    zero = np.zeros_like(half)
    out = rotations.copy()
    out[:, j] = rotation.multiply(out[:, j], np.stack([np.cos(half), zero, zero, np.sin(half)], -1))
    return out


def leant(rotations: np.ndarray, pelvis: np.ndarray, spine: np.ndarray, gaze: bool = True) -> np.ndarray:
    """Return rotations (T, J, 4) with pelvis and spine bent forward by angles (T,), mostly compensated by the head."""
    out = pitched(rotations, "pelvis", pelvis)
    for name, share in SPINE.items():
        out = pitched(out, name, share * spine)
    if gaze:
        for name, share in GAZE.items():
            out = pitched(out, name, -share * (pelvis + spine))
    return out


def ankles(root: np.ndarray, rotations: np.ndarray) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return positions (T, 3) of the ankles and world rotations (T, 4) of the feet, by side."""
    positions, turned = skeleton.forward_kinematics(root, rotations, REST)
    index = {side: skeleton.INDEX[f"{side}_ankle"] for side in ("left", "right")}
    return {s: positions[:, k] for s, k in index.items()}, {s: turned[:, k] for s, k in index.items()}


def planted(
    root: np.ndarray, rotations: np.ndarray, places: dict[str, np.ndarray], feet: dict[str, np.ndarray]
) -> np.ndarray:
    """Return rotations (T, J, 4) with ankles at places (T, 3) and feet at world rotations (T, 4)."""
    out = rotations
    for side in ("left", "right"):
        out = solve_limb(root, out, REST, f"{side}_leg", places[side])
    _, turned = skeleton.forward_kinematics(root, out, REST)
    for side in ("left", "right"):
        j = skeleton.INDEX[f"{side}_ankle"]
        out[:, j] = rotation.multiply(rotation.conjugate(turned[:, skeleton.PARENTS[j]]), feet[side])
    return out


def end_turned(root: np.ndarray, rotations: np.ndarray, joint: str, world: np.ndarray) -> np.ndarray:
    """Return rotations (T, J, 4) with one joint at a world rotation (T, 4)."""
    j = skeleton.INDEX[joint]
    _, turned = skeleton.forward_kinematics(root, rotations, REST)
    out = rotations.copy()
    out[:, j] = rotation.multiply(rotation.conjugate(turned[:, skeleton.PARENTS[j]]), world)
    return out


BALL = 0.13  # metres from the ankle forward to the ball of the foot


def tiptoed(
    places: dict[str, np.ndarray], feet: dict[str, np.ndarray], rise: np.ndarray
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return ankles (T, 3) and foot rotations (T, 4) with heels raised by rise (T,), metres, about the balls."""
    angle = np.arcsin(np.clip(rise / BALL, 0.0, 0.9))
    half = angle / 2
    zero = np.zeros_like(half)
    bend = np.stack([np.cos(half), np.sin(half), zero, zero], -1)
    up = np.stack([zero, rise, BALL * (1 - np.cos(angle))], -1)
    return {s: p + up for s, p in places.items()}, {s: rotation.multiply(f, bend) for s, f in feet.items()}


def flat_toes(rotations: np.ndarray, rise: np.ndarray) -> np.ndarray:
    """Return rotations (T, J, 4) with toes bent up by the angle with which tiptoed pitches the feet."""
    angle = np.arcsin(np.clip(rise / BALL, 0.0, 0.9))
    for side in ("left", "right"):
        rotations = pitched(rotations, f"{side}_foot", -angle)
    return rotations


def trunk_lean(root: np.ndarray, rotations: np.ndarray, facing: np.ndarray) -> np.ndarray:
    """Return the backward lean (T,), radians, of the line hip centre to neck; facing: (3,) or (T, 3) horizontal."""
    positions, _ = skeleton.forward_kinematics(root, rotations, REST)
    hips = positions[:, [1, 2]].mean(1)
    up = positions[:, skeleton.INDEX["neck"]] - hips
    return np.arctan2(-(up * facing).sum(-1), up[:, 1])


def knees(root: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    """Return the flexion (T, 2) of both knees, degrees."""
    joints, _ = skeleton.forward_kinematics(root, rotations, REST)
    angles = []
    for side in ("left", "right"):
        hip, knee, ankle = (joints[:, skeleton.INDEX[f"{side}_{n}"]] for n in ("hip", "knee", "ankle"))
        a, b = knee - hip, ankle - knee
        cosine = (a * b).sum(-1) / (np.linalg.norm(a, axis=-1) * np.linalg.norm(b, axis=-1))
        angles.append(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
    return np.stack(angles, -1)
