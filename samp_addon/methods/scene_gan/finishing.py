"""From what the networks made to a take: on the floor, feet locked, contacts and actions labelled."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d, uniform_filter1d

from ... import skeleton
from ...motion import Motion
from ...refine.feet.foot_lock import lock_feet
from ...vocabulary import ACTIONS, CONTACTS
from .ground import Ground

FEET = ("right", "left")
LOW, SLOW = 0.05, 0.35
"""A ball of a foot that is lower over the lowest one of its time and slower stands; metres and m/s."""
DROP_SIGMA = 5.0  # frames
WALKING = 0.35  # m/s of the pelvis


def finish(root: np.ndarray, rotations: np.ndarray, ground: Ground, rest: np.ndarray) -> Motion:
    """Return the finished motion of a pelvis (T, 3) and rotations (T, 22, 4)."""
    motion = Motion(root, rotations)
    floor = ground.floor(root - [0.0, ground.standing, 0.0])
    lifted = root + _drop(motion, floor, rest)[:, None] * np.array([0.0, 1.0, 0.0])
    motion = replace(motion, root=lifted)
    upright = ground.upright(lifted)
    motion = replace(motion, contacts=contacts(motion, floor, upright), actions=actions(motion, upright))
    seated = np.flatnonzero(upright)
    start = int(seated[-1]) + 1 if len(seated) and seated[-1] + 1 < len(root) else None
    return replace(lock_feet(motion, floor), interaction_start=start)


def _sole(rest: np.ndarray) -> float:
    """Return how far the sole is under the ball's joint, metres."""
    from ...body import human

    return -human.load().floor + float(rest[:, 1].min())


def _lowest(motion: Motion) -> np.ndarray:
    """Return the height (T,) of the lower ball of the feet."""
    joints, _ = motion.forward_kinematics()
    return joints[:, [skeleton.INDEX["left_foot"], skeleton.INDEX["right_foot"]], 1].min(1)


def _drop(motion: Motion, floor: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """Return the smooth change of height (T,) that puts the lower foot onto the floor (T,)."""
    change = floor + _sole(rest) - _lowest(motion)
    return gaussian_filter1d(change, DROP_SIGMA, mode="nearest")


def contacts(motion: Motion, floor: np.ndarray, upright: np.ndarray) -> np.ndarray:
    """Return contacts (T, 5) by height and speed of the feet; the pelvis is in contact while it is low."""
    joints, _ = motion.forward_kinematics()
    found = np.zeros((len(motion), len(CONTACTS)))
    found[:, CONTACTS.index("pelvis")] = ~upright
    lowest = _lowest(motion)
    for side in FEET:
        ball = joints[:, skeleton.INDEX[f"{side}_foot"]]
        speed = np.linalg.norm(np.gradient(ball[:, [0, 2]], axis=0), axis=-1) * motion.fps
        stands = (uniform_filter1d(speed, 3) < SLOW) & (ball[:, 1] < lowest + LOW)
        found[:, CONTACTS.index(f"{side}_foot")] = stands
    return found


def actions(motion: Motion, upright: np.ndarray) -> np.ndarray:
    """Return weights (T, 5) of what is done: sitting while the pelvis is low, else walking or standing by speed."""
    if len(motion) > 1:
        speed = np.linalg.norm(np.gradient(motion.root[:, [0, 2]], axis=0), axis=-1) * motion.fps
    else:
        speed = np.zeros(len(motion))
    walks = uniform_filter1d(speed, 9) > WALKING
    names = np.where(~upright, "sit", np.where(walks, "walk", "idle"))
    return np.stack([(names == name).astype(float) for name in ACTIONS], axis=-1)
