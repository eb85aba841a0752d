"""Estimate the true lengths of a captured body's legs and arms from their reach when straight.

The limb lengths of a solved skeleton depend on the placement of its joint centres, and one per cent too much adds 15
degrees to a knee: the cosine is flat near straight limbs. Captured people stand with a flexion of 12 to 15 degrees and
straighten to 7 to 10.
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
"""Limits of the corrections; larger errors are not caused by joint centres."""

UPRIGHT = 0.88  # height of the hips over the lower ankle, in leg lengths
WALK, STAND = 1.8, 0.12  # highest speed of the hips while walking and standing, leg lengths a second
FEWEST, FEWEST_IDLE = 120, 90  # frames (both sides counted) needed to estimate a length


def reach(flexion: float, limb: str) -> float:
    """Return a limb's reach over its length at a flexion (radians) of its middle joint, on the default human."""
    upper, lower = limb_lengths(
        skeleton.default_rest_joints(), [skeleton.INDEX[name] for name in LIMBS[limb]]
    )
    return float(np.sqrt(upper**2 + lower**2 + 2 * upper * lower * np.cos(flexion)) / (upper + lower))


def corrections(recordings: Sequence[Recording], mapping: Mapping) -> tuple[float, float]:
    """Return the divisors of one subject's leg and arm lengths that match their reach; 1 with too few frames."""
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
    estimates = []
    if len(legs) >= FEWEST:
        estimates.append(reach(STRAIGHTEST, "left_leg") / np.percentile(legs, 90))
    if len(idle) >= FEWEST_IDLE:  # counted twice: a crouch shows most clearly while standing
        estimates += 2 * [reach(IDLE, "left_leg") / np.median(idle)]
    leg = float(np.clip(np.mean(estimates), *LEG_RANGE)) if estimates else 1.0
    arm = 1.0
    if len(arms) >= FEWEST:
        arm = float(np.clip(reach(ELBOW, "left_arm") / np.percentile(arms, 95), *ARM_RANGE))
    return leg, arm


def _upright(joints: np.ndarray, mapping: Mapping, fps: float) -> tuple[np.ndarray, np.ndarray]:
    """Flag frames (T,) in which the body stands or walks, and frames (T,) in which it stands
    still."""
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
    """Return the distance (T,) from start to end of a limb over its length in the rest pose."""
    k = [mapping.bones.get(name, -1) for name in LIMBS[limb]]
    if min(k) < 0:
        return np.zeros(0)
    way = recording.positions[:, k[2]] - recording.positions[:, k[0]]
    return np.linalg.norm(way, axis=-1) / sum(limb_lengths(recording.rest, k))


def limb_lengths(joints: np.ndarray, k: Sequence[int]) -> tuple[float, float]:
    """Return the lengths of a limb's two bones. joints: (J, 3). k: indices of its start, middle and end."""
    upper = np.linalg.norm(joints[k[1]] - joints[k[0]])
    return float(upper), float(np.linalg.norm(joints[k[2]] - joints[k[1]]))
