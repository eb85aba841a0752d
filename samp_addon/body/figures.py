"""Plain poses of a body that stands, sits or lies, to show where one would be. Network frame, metres, radians."""

from __future__ import annotations

import math

import numpy as np

from .. import rotation, skeleton
from ..motion import Motion

ARMS, ELBOWS = 1.2, 0.35
"""Turn of the arms from stretched out to hanging, and of the forearms forward."""

SHIN = 0.50
"""Height of a knee over the sole of a foot that stands."""

THIGH = 0.42
"""Length of a thigh."""

HIP_OVER = -0.07
"""Height of the hip joints over the pelvis joint."""

STEEPEST = 0.6
"""Steepest slope of a seated thigh."""

ON_LAP = {"elbows": 0.9, "arms": 1.15}


def figure(action: str, over_floor: float = 0.6) -> Motion:
    """Return one frame of a body that faces +Z with its pelvis at the origin.

    action: "sit", "lie", or anything else for standing. over_floor: height of a seated pelvis over the floor.
    """
    turns = {
        "left_shoulder": (0, 0, -ARMS),
        "right_shoulder": (0, 0, ARMS),
        "left_elbow": (0, -ELBOWS, 0),
        "right_elbow": (0, ELBOWS, 0),
    }
    if action == "sit":
        drop = math.asin(np.clip((over_floor + HIP_OVER - SHIN) / THIGH, -STEEPEST, STEEPEST))
        hip, knee = -(math.pi / 2 - drop), math.pi / 2 - drop
        for side, sign in (("left", 1), ("right", -1)):
            turns[f"{side}_hip"] = (hip, 0.06 * sign, 0)
            turns[f"{side}_knee"] = (knee, 0, 0)
            turns[f"{side}_shoulder"] = (0, 0, -ON_LAP["arms"] * sign)
            turns[f"{side}_elbow"] = (0, -ON_LAP["elbows"] * sign, 0)
    elif action == "lie":
        turns["left_elbow"], turns["right_elbow"] = (0, -0.1, 0), (0, 0.1, 0)
        turns["pelvis"] = (-math.pi / 2, 0, 0)
    rotations = np.zeros((1, skeleton.BODY_COUNT, 4))
    rotations[..., 0] = 1.0
    for name, axis_angle in turns.items():
        rotations[0, skeleton.INDEX[name]] = rotation.from_axis_angle(np.array(axis_angle, float))
    return Motion(np.zeros((1, 3)), rotations)
