"""From what the networks made to a take: on the floor, feet locked, contacts and actions labelled."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from ...motion import Motion
from ...refine.feet.foot import FEET
from ...refine.feet.foot_lock import FOUND, lock_feet
from ...refine.feet.found_contacts import foot_contacts
from ...refine.feet.grounding import grounded
from ...vocabulary import ACTIONS, CONTACTS
from .ground import Ground

WALKING = 0.35  # m/s of the pelvis


def finish(root: np.ndarray, rotations: np.ndarray, ground: Ground) -> Motion:
    """Return the finished motion of a pelvis (T, 3) and rotations (T, 22, 4)."""
    motion = Motion(root, rotations)
    floor = ground.floor(root - [0.0, ground.standing, 0.0])
    motion = grounded(motion, floor)
    upright = ground.upright(motion.root)
    motion = replace(motion, contacts=contacts(motion, upright), actions=actions(motion, upright))
    seated = np.flatnonzero(upright)
    start = int(seated[-1]) + 1 if len(seated) and seated[-1] + 1 < len(root) else None
    return replace(lock_feet(motion, floor, FOUND), interaction_start=start)


def contacts(motion: Motion, upright: np.ndarray) -> np.ndarray:
    """Return contacts (T, 5) of the feet; the pelvis is in contact while it is low."""
    found = np.zeros((len(motion), len(CONTACTS)))
    found[:, CONTACTS.index("pelvis")] = ~upright
    found[:, [foot.column for foot in FEET]] = foot_contacts(motion)
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
