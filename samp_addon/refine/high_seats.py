"""Seats so high that the thighs of feet that stand flat pass through their front edge.

The knees are raised there: the feet come nearer, on tiptoe, or hang. Network frame, metres.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .. import rotation, skeleton
from ..easing import anticipate
from ..motion import Motion
from .feet.foot import FEET, Foot
from .inverse_kinematics import at_height

if TYPE_CHECKING:
    from .thin_things import ThinThings

RATE = 10.0
"""Frames per second in which thighs are looked at."""

ON_PELVIS, ON_THIGH = 0.25, 0.4
"""Shares of the thigh, from the hip: raising the pelvis clears it up to the first, raising the knee from the second."""

UPRIGHT = 0.5
"""Vertical component of the trunk of a body that sits; others lie."""

WORTH = 0.012
"""Metres of rise below which feet stay flat."""

MOST_RISE = 0.16
"""Metres by which a knee rises at most."""

STRAIGHTEST = 0.96
"""Share of the shin's length by which a hanging ankle is under its knee: calves keep off the front of the seat."""

MOST_TILT = np.radians(28.0)
"""Largest turn of a hanging foot towards its toes."""

FOOT = 0.135
"""Metres from the ankle to the ball of a foot."""

WINDOW, SIGMA = 0.3, 0.10
"""Seconds over which heels rise early, and standard deviation of the Gaussian over it."""


def knee_rises(motion: Motion, thin: ThinThings) -> np.ndarray:
    """Return the metres (T, 2), right leg first, by which each knee is too low for the seat under its thigh."""
    rises = np.zeros((len(motion), len(FEET)))
    rows = np.arange(0, len(motion), max(1, round(motion.fps / RATE)))
    sampled = motion.pose_slice(rows)
    row, vertex, point, depth = thin.seats(sampled)
    joints = sampled.forward_kinematics()[0]
    trunk = joints[:, skeleton.INDEX["neck"]] - joints[:, 0]
    upright = (trunk[:, 1] > UPRIGHT * np.linalg.norm(trunk, axis=-1))[row]
    row, vertex, point, depth = row[upright], vertex[upright], point[upright], depth[upright]
    carrier = thin.carriers[vertex]
    for column, foot in enumerate(FEET):
        own = carrier == foot.hip
        hip, thigh = joints[row, foot.hip], joints[row, foot.knee] - joints[row, foot.hip]
        share = ((point - hip) * thigh).sum(-1) / np.square(thigh).sum(-1)
        lift, need = np.zeros(len(rows)), np.zeros(len(rows))
        low = own & (share < ON_PELVIS)
        np.maximum.at(lift, row[low], depth[low])
        ahead = own & (share > ON_THIGH)
        missing = depth - lift[row] * (1 - np.minimum(share, 1.0))
        np.maximum.at(need, row[ahead], (missing / np.maximum(share, ON_THIGH))[ahead])
        rises[:, column] = np.interp(np.arange(len(motion)), rows, need)
    rises[rises < WORTH] = 0.0
    if not rises.any():
        return rises
    frames = max(1, round(WINDOW * motion.fps))
    return np.stack(
        [anticipate(np.minimum(one, MOST_RISE), frames, SIGMA * motion.fps) for one in rises.T], axis=-1
    )


def knees_raised(motion: Motion, rises: np.ndarray) -> Motion:
    """Return the motion with its knees raised by (T, 2) metres, right leg first.

    Feet stay as high as they are where the shins are long enough for that, nearer to the body; else they hang.
    """
    for foot, rise in zip(FEET, rises.T, strict=True):
        if rise.any():
            motion = _knee_raised(motion, foot, rise)
    return motion


def _knee_raised(motion: Motion, foot: Foot, rise: np.ndarray) -> Motion:
    joints, globals_ = motion.forward_kinematics()
    thigh = joints[:, foot.knee] - joints[:, foot.hip]
    shin = joints[:, foot.ankle] - joints[:, foot.knee]
    raised = at_height(thigh, np.minimum(thigh[:, 1] + rise, 0.0), thigh[:, [0, 2]])
    raised = np.where((rise > 0)[:, None], raised, thigh)
    above = raised[:, 1] - thigh[:, 1]
    length = np.linalg.norm(shin, axis=-1)
    drop = np.minimum(above - shin[:, 1], np.maximum(STRAIGHTEST * length, -shin[:, 1]))
    lowered = np.where((rise > 0)[:, None], at_height(shin, -drop, shin[:, [0, 2]]), shin)
    hanging = np.maximum(above - shin[:, 1] - drop, 0.0)
    first = rotation.between(thigh, raised)
    second = rotation.multiply(rotation.between(rotation.rotate(first, shin), lowered), first)
    toes = joints[:, foot.ball] - joints[:, foot.ankle]
    across = np.stack([toes[:, 2], np.zeros(len(toes)), -toes[:, 0]], -1)
    across /= np.maximum(np.linalg.norm(across, axis=-1, keepdims=True), 1e-9)
    tilt = np.minimum(np.arcsin(np.clip(hanging / FOOT, 0.0, 1.0)), MOST_TILT)
    third = rotation.from_axis_angle(tilt[:, None] * across)
    turned = {
        joint: rotation.multiply(turn, globals_[:, joint])
        for joint, turn in ((foot.hip, first), (foot.knee, second), (foot.ankle, third))
    }
    rotations, above_hip = motion.rotations.copy(), globals_[:, skeleton.PARENTS[foot.hip]]
    for joint, parent in (
        (foot.hip, above_hip), (foot.knee, turned[foot.hip]), (foot.ankle, turned[foot.knee]),
    ):  # fmt: skip
        rotations[:, joint] = rotation.multiply(rotation.conjugate(parent), turned[joint])
    return replace(motion, rotations=rotations)
