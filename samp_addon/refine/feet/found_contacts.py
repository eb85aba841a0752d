"""Which feet stand, found from the motion itself. Network frame, metres."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d, minimum_filter1d

from ...motion import Motion, velocities
from .foot import FEET
from .grounding import sole_heights

STILL = 0.35
"""Metres per second under which a foot stands."""
LOW = 0.045
"""Metres over the lowest sole of a second and a third up to which a foot is on the ground."""
HEIGHT_COST = 10.0
"""1 / second: a foot that is a centimetre higher counts as a tenth of a metre per second faster."""
FASTEST = 2.0
"""Metres per second of the pelvis from which both feet may be in the air."""
AROUND = 41
"""Frames in which the lowest sole is looked for."""


def foot_contacts(motion: Motion) -> np.ndarray:
    """Return contacts (T, 2), 0 or 1, in the order of FEET.

    A foot that is low and slow stands. Feet of generated motion slide; so where neither does, the slower and lower one
    stands all the same, unless the body runs: people who walk always stand on a foot, and the foot lock lifts all
    others.
    """
    positions, _ = motion.forward_kinematics()
    balls = [velocities(positions[:, foot.ball], motion.fps) for foot in FEET]
    speed = np.stack([np.linalg.norm(ball, axis=-1) for ball in balls], axis=-1)
    speed = gaussian_filter1d(speed, 1.0, axis=0, mode="nearest")
    height = sole_heights(motion)
    over = height - minimum_filter1d(height.min(1), AROUND, mode="nearest")[:, None]
    stands = (speed < STILL) & (over < LOW)
    pace = np.linalg.norm(velocities(motion.root, motion.fps)[:, [0, 2]], axis=-1)
    needed = ~stands.any(1) & (pace < FASTEST)
    stands[needed, (speed + HEIGHT_COST * over).argmin(1)[needed]] = True
    return (gaussian_filter1d(stands.astype(float), 1.0, axis=0, mode="nearest") > 0.5).astype(float)
