"""A take on a body of other proportions: rotations stay, the root's height follows the legs.

Limit: the way over the floor stays too, since the take must end where the goal is; longer or shorter legs
therefore slide by the difference of their strides, and a foot lock on the new body is what removes that.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .. import skeleton
from ..motion import CONTACTS, Motion

# Height of the pelvis joint over the seat it rests on, of the default human, metres.
_SEAT_THICKNESS = 0.09
_FEET = [skeleton.INDEX[f"{side}_{part}"] for side in ("left", "right") for part in ("ankle", "foot")]


def leg_length(rest_joints: np.ndarray) -> float:
    """Hip to knee to ankle, mean of both sides, metres, of rest joints (22 or more, 3)."""
    length = 0.0
    for joint in ("knee", "ankle"):
        for side in ("left", "right"):
            j = skeleton.INDEX[f"{side}_{joint}"]
            length += float(np.linalg.norm(rest_joints[j] - rest_joints[skeleton.PARENTS[j]]))
    return length / 2


def adapt(motion: Motion, rest_joints: np.ndarray) -> Motion:
    """The take for a body with these rest joints (J or more, 3; metres, pelvis at the origin).

    While the pelvis rests on something (contacts[:, 0]) its height over the seat stays but for the
    thickness of the body; else the lowest foot keeps its height over the floor. Without contacts the feet
    decide everywhere.
    """
    if np.abs(rest_joints[: skeleton.BODY_COUNT] - motion.rest_joints[: skeleton.BODY_COUNT]).max() < 1e-4:
        return replace(motion, rest_joints=rest_joints)
    ratio = leg_length(rest_joints) / leg_length(motion.rest_joints)
    standing = _lowest_foot(motion, motion.rest_joints) - _lowest_foot(motion, rest_joints)
    # The sole lies below the joints that are compared, by more the larger the foot is.
    standing += (ratio - 1) * _sole_depth(motion.rest_joints)
    seated = (ratio - 1) * _SEAT_THICKNESS
    resting = 0.0 if motion.contacts is None else np.clip(motion.contacts[:, CONTACTS.index("pelvis")], 0, 1)
    root = motion.root.copy()
    root[:, 1] += (1 - resting) * standing + resting * seated
    return replace(motion, root=root, rest_joints=rest_joints)


def _lowest_foot(motion: Motion, rest_joints: np.ndarray) -> np.ndarray:
    """Height (T,) of the lowest ankle or foot joint over the root."""
    still = np.zeros_like(motion.root)
    positions, _ = skeleton.forward_kinematics(still, motion.rotations[:, : skeleton.BODY_COUNT], rest_joints)
    return positions[:, _FEET, 1].min(axis=1)


def _sole_depth(rest_joints: np.ndarray) -> float:
    """How far the sole lies under the lowest foot joint, metres; a foot's depth scales with the leg."""
    default = skeleton.default_rest_joints()
    return 0.021 * leg_length(rest_joints) / leg_length(default)
