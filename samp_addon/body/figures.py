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
ON_TABLE, LEANING, CROSSED = 1.5, 0.4, 0.4
"""Bend of the elbows at a table; turn of a trunk that leans back, and of thighs whose ankles cross."""


def figure(action: str, over_floor: float = 0.6, posture: str = "") -> Motion:
    """Return one frame of a body that faces +Z with its pelvis at the origin.

    action: "sit", "lie", or anything else for standing. over_floor: height of a seated pelvis over the floor. posture:
    of a seated body, one of vocabulary.POSTURES; those that are not drawn look like the usual one.
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
            bent = ON_TABLE if posture == "hands_on_table" else ON_LAP["elbows"]
            turns[f"{side}_elbow"] = (0, -bent * sign, 0)
        if posture == "lean_back":
            turns["pelvis"] = (-LEANING, 0, 0)
            turns |= {f"{side}_hip": (hip + LEANING, 0, 0) for side in ("left", "right")}
    elif action == "lie":
        turns["left_elbow"], turns["right_elbow"] = (0, -0.1, 0), (0, 0.1, 0)
        turns["pelvis"] = (-math.pi / 2, 0, 0)
    rotations = np.zeros((1, skeleton.BODY_COUNT, 4))
    rotations[..., 0] = 1.0
    for name, axis_angle in turns.items():
        rotations[0, skeleton.INDEX[name]] = rotation.from_axis_angle(np.array(axis_angle, float))
    if posture == "legs_crossed":
        for side, sign in (("left", -1.0), ("right", 1.0)):
            hip = skeleton.INDEX[f"{side}_hip"]
            out = rotation.from_axis_angle(np.array([0.0, 0.0, sign * CROSSED]))
            rotations[0, hip] = rotation.multiply(out, rotations[0, hip])
    return Motion(np.zeros((1, 3)), rotations)
