"""Feet on uneven ground: each at the height of the ground under it, its sole along the slope. Network frame, metres."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ..... import rotation
from .....motion import Motion
from .....refine.feet.corrections import Correction, apply
from .....refine.feet.foot import FEET, Foot, sole_points

Ground = Callable[[np.ndarray], np.ndarray]
"""Returns the heights (N,) of the ground near points (N, 3), NaN where there is none."""

EVEN = 0.02
"""Metres by which the floor under a route varies on even ground: rugs, sills, and cells of the navmesh."""

SIGMA = 2.0
"""Frames at 30 fps of the Gaussian over the heights under a foot, which change in steps while it swings."""

MOST_RISE = 0.3
"""Metres between the ground under a foot and under the pelvis."""

SINK_SIGMA, SLACK = 4.0, 0.03
"""Frames of the Gaussian over the pelvis' sinking, and metres that walking legs can be lengthened by."""


def follow(motion: Motion, heights: np.ndarray, ground: Ground | None) -> Motion:
    """Return a motion whose feet follow the ground under them.

    heights: (T,) of the flat floor that the motion was made for, under its pelvis. The motion is unchanged on even
    ground. Raises ValueError without motion.contacts.
    """
    if ground is None:
        return motion
    if motion.contacts is None:
        raise ValueError("feet on uneven ground need the motion's contacts")
    corrections = [_correction(motion, foot, heights, ground) for foot in FEET]
    usual = max(np.median(np.abs(one.offset[:, 1])) for one in corrections)
    if np.ptp(heights) < EVEN and usual < EVEN / 2:
        return motion
    rises = [np.where(one.standing, one.offset[:, 1], 0.0) for one in corrections]
    lowest = np.minimum(np.min(rises, axis=0) + SLACK, 0.0)
    sunk = motion.root.copy()
    sunk[:, 1] += gaussian_filter1d(lowest, SINK_SIGMA * motion.fps / 30, mode="nearest")
    sink = (motion.root - sunk)[:, 1]
    lifted = [replace(one, offset=one.offset + sink[:, None] * [0.0, 1.0, 0.0]) for one in corrections]
    return apply(replace(motion, root=sunk), lifted, lambda tips: _near(ground, tips, heights))


def _correction(motion: Motion, foot: Foot, heights: np.ndarray, ground: Ground) -> Correction:
    """Return the correction that puts a foot from a flat floor (T,) onto the ground, turned along its slope."""
    positions, globals_ = motion.forward_kinematics()
    heel, ball = sole_points(positions, globals_, motion.rest_joints, foot.side)
    ankle = positions[:, foot.ankle]
    sigma = SIGMA * motion.fps / 30
    under_heel, under_ball = (
        gaussian_filter1d(_near(ground, points, heights), sigma, mode="nearest") for points in (heel, ball)
    )
    along = (ball - heel) * [1.0, 0.0, 1.0]
    length = np.maximum(np.linalg.norm(along, axis=-1), 0.05)
    share = np.clip(((ankle - heel) * along).sum(-1) / length**2, 0.0, 1.0)
    rise = under_heel + share * (under_ball - under_heel) - heights
    pitch = np.arctan2(under_ball - under_heel, length)
    across = np.stack([along[:, 2], np.zeros(len(along)), -along[:, 0]], -1) / length[:, None]
    turn = rotation.from_axis_angle(-pitch[:, None] * across)
    offset = np.clip(rise, -MOST_RISE, MOST_RISE)[:, None] * np.array([0.0, 1.0, 0.0])
    standing = motion.contacts[:, foot.column] > 0.5
    return Correction(foot, offset, standing, rotation.multiply(turn, globals_[:, foot.ankle]))


def _near(ground: Ground, points: np.ndarray, heights: np.ndarray) -> np.ndarray:
    """Return the heights (T,) of the ground under points (T, 3) whose height is that of the floor (T,)."""
    found = ground(np.stack([points[:, 0], heights, points[:, 2]], -1))
    known = np.isfinite(found) & (np.abs(found - heights) <= MOST_RISE)
    if not known.any():
        return heights.copy()
    frames = np.arange(len(found))
    return heights + np.interp(frames, frames[known], (found - heights)[known])
