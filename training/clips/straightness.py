"""How long a captured body's legs and arms really are, told by how far they reach when they are straight.

A solved skeleton's limbs are as long as its joint centres are well placed, and a per cent too much is 15 degrees
in a knee: cos is flat near straight limbs. Captured people stand with 12 to 15 degrees and straighten to 7 to 10.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...samp_addon import skeleton
from ...samp_addon.refine.inverse_kinematics import LIMBS
from .mapping import Mapping, places
from .recording import Recording

STRAIGHTEST, IDLE = np.radians(8.0), np.radians(12.0)
"""Knee flexion of the straightest tenth of standing and walking, and the median of standing."""

ELBOW = np.radians(12.0)
"""Elbow flexion of the straightest twentieth."""

LEG_RANGE, ARM_RANGE = (0.985, 1.045), (1.0, 1.04)
"""Corrections outside of these are no matter of joint centres."""

UPRIGHT = 0.88  # height of the hips over the lower ankle, in lengths of a leg
WALK, STAND = 1.8, 0.12  # leg lengths a second of the hips, at most, while walking and standing
FEWEST, FEWEST_IDLE = 120, 90  # frames (both sides counted) that tell a length


def reach(flexion: float, limb: str) -> float:
    """From a limb's start to its end over its length, at a flexion (radians) of its middle joint, on our body."""
    upper, lower = limb_lengths(
        skeleton.default_rest_joints(), [skeleton.INDEX[name] for name in LIMBS[limb]]
    )
    return float(np.sqrt(upper**2 + lower**2 + 2 * upper * lower * np.cos(flexion)) / (upper + lower))


def corrections(recordings: Sequence[Recording], mapping: Mapping) -> tuple[float, float]:
    """What legs and arms of one person have to be divided by to be as long as they reach; 1 where nothing tells."""
    legs, idle, arms = [], [], []
    for one in recordings:
        joints = places(one, mapping) / mapping.leg
        upright, still = _upright(joints, mapping, one.fps)
        for side in ("left", "right"):
            leg = limb_reach(one, mapping, f"{side}_leg")
            legs.append(leg[upright])
            idle.append(leg[upright & still])
            arm = limb_reach(one, mapping, f"{side}_arm")
            arms.append(arm[upright] if len(arm) else arm)
    legs, idle, arms = np.concatenate(legs), np.concatenate(idle), np.concatenate(arms)
    told = []
    if len(legs) >= FEWEST:
        told.append(reach(STRAIGHTEST, "left_leg") / np.percentile(legs, 90))
    if len(idle) >= FEWEST_IDLE:  # counted twice: standing is what a crouch is seen in
        told += 2 * [reach(IDLE, "left_leg") / np.median(idle)]
    leg = float(np.clip(np.mean(told), *LEG_RANGE)) if told else 1.0
    arm = 1.0
    if len(arms) >= FEWEST:
        arm = float(np.clip(reach(ELBOW, "left_arm") / np.percentile(arms, 95), *ARM_RANGE))
    return leg, arm


def _upright(joints: np.ndarray, mapping: Mapping, fps: float) -> tuple[np.ndarray, np.ndarray]:
    """Flags (T,) of frames in which the body stands or walks, and of those in which it stands still."""
    at = lambda joint: joints[:, mapping.bones[joint]]
    hips = (at("left_hip") + at("right_hip")) / 2
    low = np.minimum(at("left_ankle")[:, 1], at("right_ankle")[:, 1])
    speed = (
        lambda x: np.linalg.norm(np.gradient(x, 1 / fps, axis=0), axis=-1) if len(x) > 1 else np.zeros(len(x))
    )
    moving = speed(hips)
    steps = np.maximum(speed(at("left_ankle")), speed(at("right_ankle")))
    upright = (hips[:, 1] - low > UPRIGHT) & (moving < WALK)
    return upright, (moving < STAND) & (steps < STAND)


def limb_reach(recording: Recording, mapping: Mapping, limb: str) -> np.ndarray:
    """From start to end of a limb over its length in the rest pose (T,)."""
    k = [mapping.bones.get(name, -1) for name in LIMBS[limb]]
    if min(k) < 0:
        return np.zeros(0)
    way = recording.positions[:, k[2]] - recording.positions[:, k[0]]
    return np.linalg.norm(way, axis=-1) / sum(limb_lengths(recording.rest, k))


def limb_lengths(joints: np.ndarray, k: Sequence[int]) -> tuple[float, float]:
    """From a limb's start to its middle and from there to its end: joints (J, 3), k their three indices."""
    upper = np.linalg.norm(joints[k[1]] - joints[k[0]])
    return float(upper), float(np.linalg.norm(joints[k[2]] - joints[k[1]]))
