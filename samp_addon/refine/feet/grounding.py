"""The whole body raised or lowered so that its lower foot stands on the floor. Network frame, metres."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ...motion import Motion
from .foot import FEET, sole_points

SIGMA = 4.0
"""Frames over which the change of height is smoothed."""
STANDS = 0.02
"""Weight of sitting and lying among the actions below which the feet carry the body."""


def grounded(motion: Motion, floor: np.ndarray, resting: np.ndarray | float = 0.0) -> Motion:
    """Return the motion with its lowest sole on the floor (T,).

    resting: weight of sitting and lying among the actions, from 0 to 1, (T,) or one number. While a body sits or lies
    down, the change of height of its last standing frame fades as this weight rises.
    """
    resting, frames = np.broadcast_to(resting, len(motion)), np.arange(len(motion))
    height = floor - lowest_sole(motion)
    stands = np.flatnonzero(resting < STANDS)
    height = np.interp(frames, stands, height[stands]) * (1 - resting) if len(stands) else 0 * height
    change = gaussian_filter1d(height, SIGMA, mode="nearest")
    return replace(motion, root=motion.root + change[:, None] * np.array([0.0, 1.0, 0.0]))


def lowest_sole(motion: Motion) -> np.ndarray:
    """Return the height (T,) of the lowest heel or ball."""
    return sole_heights(motion).min(1)


def sole_heights(motion: Motion) -> np.ndarray:
    """Return the height (T, 2) of the lower one of heel and ball, in the order of FEET."""
    positions, globals_ = motion.forward_kinematics()
    ends = [sole_points(positions, globals_, motion.rest_joints, foot.side) for foot in FEET]
    return np.stack([np.minimum(heel[:, 1], ball[:, 1]) for heel, ball in ends], axis=-1)
