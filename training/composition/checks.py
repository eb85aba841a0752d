"""What a clip has to pass before it is learnt from: joints within their limits, feet that stand, no jumps."""

from __future__ import annotations

import numpy as np

from ...samp_addon import skeleton
from ...samp_addon.body.joint_limits import limits
from ..mocap.clip_files import FPS, Clip

TOO_OFTEN = 0.01  # share of frames with a joint past its limit
SLIDE = 0.06  # m/s, mean of the balls of the feet that stand
JUMP = 12.0  # m/s of any joint
SETTLING = 3  # frames after a contact begins and before it ends that are not counted


def fault(clip: Clip) -> str | None:
    """Why a clip is not fit to be learnt from, or None."""
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
    """Flags (T,) of frames in which a joint of rotations (T, 22, 4) is turned further than it can be."""
    angle = 2 * np.arccos(np.clip(np.abs(rotations[..., 0]), 0, 1))
    return (angle > limits()).any(1)


def foot_slide(clip: Clip, positions: np.ndarray) -> float:
    """Mean speed on the floor, m/s, of the balls of standing feet; 0 where none stands. positions: (T, 22, 3)."""
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
