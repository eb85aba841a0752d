"""SMPL-X's zero pose: the published joint positions of its mean body, symmetrised.

Only directions and ratios are taken from it, so that the default human's T-pose is SMPL-X's. Metres, Y up,
+Z forward; the right side mirrors the left.
"""

from __future__ import annotations

import numpy as np

from ...samp_addon import skeleton

_LEFT_AND_MIDDLE = {
    "pelvis": (0.0000, -0.3514, 0.0120),
    "left_hip": (0.0607, -0.4497, -0.0116),
    "spine1": (0.0000, -0.2415, -0.0156),
    "left_knee": (0.1102, -0.8203, -0.0247),
    "spine2": (0.0000, -0.1097, -0.0215),
    "left_ankle": (0.0807, -1.2272, -0.0507),
    "spine3": (0.0000, -0.0574, 0.0069),
    "left_foot": (0.1238, -1.2854, 0.0679),
    "neck": (0.0000, 0.1077, -0.0247),
    "left_collar": (0.0470, 0.0272, -0.0034),
    "head": (0.0000, 0.2682, -0.0040),
    "left_shoulder": (0.1579, 0.0828, -0.0174),
    "left_elbow": (0.4206, 0.0285, -0.0519),
    "left_wrist": (0.6712, 0.0379, -0.0608),
    "jaw": (0.0000, 0.2677, -0.0096),
    "left_eye_smplhf": (0.0316, 0.3108, 0.0622),
    "left_index1": (0.7721, 0.0276, -0.0413),
    "left_index2": (0.8040, 0.0298, -0.0383),
    "left_index3": (0.8266, 0.0275, -0.0383),
    "left_middle1": (0.7796, 0.0300, -0.0647),
    "left_middle2": (0.8102, 0.0308, -0.0687),
    "left_middle3": (0.8337, 0.0288, -0.0728),
    "left_pinky1": (0.7542, 0.0218, -0.1044),
    "left_pinky2": (0.7697, 0.0206, -0.1164),
    "left_pinky3": (0.7852, 0.0190, -0.1277),
    "left_ring1": (0.7676, 0.0270, -0.0880),
    "left_ring2": (0.7957, 0.0285, -0.0933),
    "left_ring3": (0.8185, 0.0271, -0.1004),
    "left_thumb1": (0.7108, 0.0183, -0.0351),
    "left_thumb2": (0.7278, 0.0193, -0.0101),
    "left_thumb3": (0.7484, 0.0142, 0.0054),
}


def zero_pose() -> np.ndarray:
    """Return the joint positions (55, 3), metres."""
    joints = np.empty((len(skeleton.JOINTS), 3))
    for j, name in enumerate(skeleton.JOINTS):
        if name.startswith("right_"):
            joints[j] = np.array(_LEFT_AND_MIDDLE[name.replace("right_", "left_")]) * (-1.0, 1.0, 1.0)
        else:
            joints[j] = _LEFT_AND_MIDDLE[name]
    return joints
