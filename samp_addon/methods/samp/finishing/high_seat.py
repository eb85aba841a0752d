"""Legs on a seat so high that the feet hang: captured people have theirs on the floor.

The network says that hanging feet stand, and the foot lock would pull the pelvis into the seat; and thighs that slope
down to feet on a floor pass through the front of the seat.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .... import rotation, skeleton
from ....easing import anticipate
from ....motion import Motion
from ....refine.feet.foot import FEET
from ....scene.seats.postures import SEAT_TO_PELVIS
from .resting import HIGH_SEAT, SIGMA, WINDOW, RestingTop, turned_bone

THICK = (0.085, 0.055)  # metres from the axis of a thigh to the skin below it, at hip and knee
GIVE = 0.02  # metres that flesh and seat yield
SHARES = np.linspace(0.3, 1.0, 8)  # places on a thigh
MAX_LIFT = 0.25  # metres by which a knee is raised


def is_on(motion: Motion) -> np.ndarray:
    """Return flags (T,) of frames in which the pelvis is as high as on a high seat."""
    return motion.root[:, 1] > HIGH_SEAT + SEAT_TO_PELVIS


def without_contacts(motion: Motion, seated: np.ndarray) -> Motion:
    """Return the motion without contacts of feet that hang. seated: (T,) flags."""
    contacts = motion.contacts.copy()
    contacts[np.ix_(seated & is_on(motion), [foot.column for foot in FEET])] = 0.0
    return replace(motion, contacts=contacts)


def with_level_thighs(motion: Motion, top: RestingTop, seated: np.ndarray) -> Motion:
    """Return the motion with knees raised until the thighs are on the seat; shins keep their direction.

    seated: (T,) flags. The floor of the motion is at height 0.
    """
    high = seated & is_on(motion)
    if not high.any():
        return motion
    for side in ("left", "right"):
        positions, globals_ = motion.forward_kinematics()
        hip, knee = (positions[:, skeleton.INDEX[f"{side}_{name}"]] for name in ("hip", "knee"))
        lift = np.zeros(len(motion))
        for share in SHARES:
            thick = THICK[0] + share * (THICK[1] - THICK[0]) - GIVE
            lift = np.maximum(lift, top.missing(hip + share * (knee - hip), thick) / share)
        lift = np.where(high, np.minimum(lift, MAX_LIFT), 0.0)
        if not lift.any():
            continue
        offset = np.zeros((len(motion), 3))
        offset[:, 1] = anticipate(lift, WINDOW, SIGMA)
        motion = turned_bone(motion, f"{side}_hip", knee, offset)
        rotations = motion.rotations.copy()
        thigh = motion.forward_kinematics()[1][:, skeleton.INDEX[f"{side}_hip"]]
        at = skeleton.INDEX[f"{side}_knee"]
        rotations[:, at] = rotation.multiply(rotation.conjugate(thigh), globals_[:, at])
        motion = replace(motion, rotations=rotations)
    return motion
