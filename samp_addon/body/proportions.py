"""Adapt a take to a body of other proportions: rotations are kept, the root's height follows the legs.

Limitation: the path over the floor is kept as well, since the take must end at the goal. Feet therefore slide by the
difference in stride length, which a foot lock on the new body removes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .. import skeleton
from ..motion import Motion
from ..vocabulary import CONTACTS

# Height of the default human's pelvis joint over the seat, metres.
_SEAT_THICKNESS = 0.09
_FEET = [skeleton.INDEX[f"{side}_{part}"] for side in ("left", "right") for part in ("ankle", "foot")]


def leg_length(rest_joints: np.ndarray) -> float:
    """Return the length hip-knee-ankle, mean of both sides, metres. rest_joints: (22 or more, 3)."""
    length = 0.0
    for joint in ("knee", "ankle"):
        for side in ("left", "right"):
            j = skeleton.INDEX[f"{side}_{joint}"]
            length += float(np.linalg.norm(rest_joints[j] - rest_joints[skeleton.PARENTS[j]]))
    return length / 2


def adapt(motion: Motion, rest_joints: np.ndarray) -> Motion:
    """Return the take for a body with other rest joints (J or more, 3; metres, pelvis at the origin).

    While the pelvis is in contact (contacts[:, 0]), its height over the seat changes by the thickness of the body only;
    otherwise the lowest foot keeps its height over the floor. Without contacts, all frames follow the feet.
    """
    if np.abs(rest_joints[: skeleton.BODY_COUNT] - motion.rest_joints[: skeleton.BODY_COUNT]).max() < 1e-4:
        return replace(motion, rest_joints=rest_joints)
    ratio = leg_length(rest_joints) / leg_length(motion.rest_joints)
    standing = _lowest_foot(motion, motion.rest_joints) - _lowest_foot(motion, rest_joints)
    # The soles are below the joints that are compared, by a distance that scales with the foot.
    standing += (ratio - 1) * _sole_depth(motion.rest_joints)
    seated = (ratio - 1) * _SEAT_THICKNESS
    resting = 0.0 if motion.contacts is None else np.clip(motion.contacts[:, CONTACTS.index("pelvis")], 0, 1)
    root = motion.root.copy()
    root[:, 1] += (1 - resting) * standing + resting * seated
    return replace(motion, root=root, rest_joints=rest_joints)


def _lowest_foot(motion: Motion, rest_joints: np.ndarray) -> np.ndarray:
    """Return the height (T,) of the lowest ankle or foot joint relative to the root, metres."""
    origin = np.zeros_like(motion.root)
    positions, _ = skeleton.forward_kinematics(
        origin, motion.rotations[:, : skeleton.BODY_COUNT], rest_joints
    )
    return positions[:, _FEET, 1].min(axis=1)


def _sole_depth(rest_joints: np.ndarray) -> float:
    """Return the depth of the sole below the lowest foot joint, metres; it scales with the leg length."""
    default = skeleton.default_rest_joints()
    return 0.021 * leg_length(rest_joints) / leg_length(default)
