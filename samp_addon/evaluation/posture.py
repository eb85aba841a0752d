"""Posture while walking, idle and seated: bent knees and elbows, the trunk's lean, the width of the stance.

Network frame, metres. Angles are in degrees; those of trunk and neck are forward of vertical.
"""

from __future__ import annotations

import numpy as np

from ..motion import Motion, velocities
from ..skeleton import INDEX
from .support import BENT, knee_flexion

WALKING, STANDING_STILL = 0.5, 0.15
"""Metres per second of the pelvis over the floor: at least while walking, at most while idle or seated."""

STRAIGHTEST = 5.0
"""Percentile of the knees' flexion that says how straight a leg becomes."""

LEAST_FRAMES = 10
"""Frames of a phase below which nothing is said of it."""

_TRUNK = {"lower_trunk": ("pelvis", "spine2"), "upper_trunk": ("spine2", "neck"), "neck": ("neck", "head")}


def phases(motion: Motion) -> dict[str, np.ndarray]:
    """Return flags (T,) of the frames that are ``walk``, ``idle`` and ``seated``."""
    velocity = velocities(motion.root, motion.fps)
    speed = np.hypot(velocity[:, 0], velocity[:, 2])
    bent = knee_flexion(motion).min(1) > BENT
    still = speed < STANDING_STILL
    return {"walk": (speed > WALKING) & ~bent, "idle": still & ~bent, "seated": still & bent}


def measures(motion: Motion) -> dict[str, float]:
    """Return the medians of each phase that occurs, such as ``idle_knee_deg``; see the module for the units.

    knee: of both knees; straight: their straightest twentieth. step_width: sideways distance of the ankles, metres.
    """
    values = _values(motion)
    knees = np.degrees(knee_flexion(motion))
    found = {}
    for name, flags in phases(motion).items():
        if flags.sum() < LEAST_FRAMES:
            continue
        if name != "seated":
            found[f"{name}_knee_deg"] = float(np.median(knees[flags]))
            found[f"{name}_straight_deg"] = float(np.percentile(knees[flags], STRAIGHTEST))
        for key, value in values.items():
            found[f"{name}_{key}"] = float(np.median(value[flags]))
    return found


def _values(motion: Motion) -> dict[str, np.ndarray]:
    """Return elbow flexion, leans (degrees) and the ankles' sideways distance (metres) in each frame, (T,) each."""
    joints = motion.forward_kinematics()[0]
    at = lambda name: joints[:, INDEX[name]]
    facing = motion.headings()
    found = {}
    elbows = []
    for side in ("left", "right"):
        upper, lower = (
            at(f"{side}_elbow") - at(f"{side}_shoulder"),
            at(f"{side}_wrist") - at(f"{side}_elbow"),
        )
        length = np.linalg.norm(upper, axis=-1) * np.linalg.norm(lower, axis=-1)
        elbows.append(np.arccos(np.clip((upper * lower).sum(-1) / np.maximum(length, 1e-9), -1, 1)))
    found["elbow_deg"] = np.degrees(np.mean(elbows, 0))
    for name, (low, high) in _TRUNK.items():
        bone = at(high) - at(low)
        found[f"{name}_deg"] = np.degrees(np.arctan2((bone * facing).sum(-1), bone[:, 1]))
    across = np.cross(facing, [0.0, 1.0, 0.0])
    found["step_width_m"] = np.abs(((at("left_ankle") - at("right_ankle")) * across).sum(-1))
    return found
