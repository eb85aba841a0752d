"""Checks that a clip has to pass before training: joints within limits, feet without sliding, no jumps."""

from __future__ import annotations

import numpy as np

from ...samp_addon import skeleton
from ...samp_addon.body.joint_limits import limits
from ..mocap.clip_files import FPS, Clip

TOO_OFTEN = 0.01  # largest share of frames with a joint past its limit
SLIDE = 0.06  # largest mean speed (m/s) of the balls of feet in contact
JUMP = 12.0  # largest speed (m/s) of any joint
SETTLING = 3  # frames excluded after the start and before the end of a contact


def fault(clip: Clip) -> str | None:
    """Return why a clip is unsuitable for training, or None."""
    if not (np.isfinite(clip.root).all() and np.isfinite(clip.rotations).all()):
        return "not finite"
    sound = ~clip.bad
    if past_limits(clip.rotations[sound]).mean() > TOO_OFTEN:
        return "joints past their limits"
    positions, _ = skeleton.forward_kinematics(clip.root, clip.rotations, skeleton.default_rest_joints())
    speed = np.linalg.norm(np.diff(positions, axis=0), axis=-1) * FPS
    if (speed[sound[1:] & sound[:-1]] > JUMP).any():
        return "jumps"
    if foot_slide(clip, positions) > SLIDE:
        return "feet slide"
    return None


def past_limits(rotations: np.ndarray) -> np.ndarray:
    """Flag frames (T,) in which a joint of rotations (T, 22, 4) exceeds its limit."""
    angle = 2 * np.arccos(np.clip(np.abs(rotations[..., 0]), 0, 1))
    return (angle > limits()).any(1)


def foot_slide(clip: Clip, positions: np.ndarray) -> float:
    """Return the mean horizontal speed, m/s, of the balls of feet in contact; 0 without contacts.

    positions: (T, 22, 3), metres.
    """
    speeds = []
    for column, side in enumerate(("right", "left")):
        ball = positions[:, skeleton.INDEX[f"{side}_foot"]][:, [0, 2]]
        stands = clip.feet[:, column] > 0.5
        for shift in range(-SETTLING, SETTLING + 1):
            stands &= np.roll(clip.feet[:, column] > 0.5, shift)
        stands = stands[1:] & ~clip.bad[1:]
        speeds.append((np.linalg.norm(np.diff(ball, axis=0), axis=-1) * FPS)[stands])
    every = np.concatenate(speeds)
    return float(every.mean()) if len(every) else 0.0
