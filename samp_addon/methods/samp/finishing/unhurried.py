"""Bodies that move over a mattress no faster than captured ones.

The two captured reclines move the pelvis by at most 0.4 m/s. The lies of the training data are these, carried from a
floor to beds: people who sit at the edge of a bed have farther to go to its middle in the same time, and MotionNet has
learned their haste.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from ....motion import Motion

MOST = 0.5
"""Metres per second of the pelvis of a body on a bed."""

OVER = 0.25
"""Metres over the lying pelvis below which a body is on the bed."""

BESIDE, SMOOTHED = 3, 3.0
"""Frames at 30 fps before and after a fast one that take longer as well, and standard deviation over which the pace
changes."""


def unhurried(motion: Motion, heights: np.ndarray, goal: np.ndarray) -> tuple[Motion, np.ndarray]:
    """Return a motion that takes longer where its pelvis is faster than MOST on the bed of a goal, and its heights.

    heights: (T,) of the floor under it. goal: row of Route.goals. Places and poses stay as they are; only when they are
    reached changes.
    """
    start = motion.interaction_start
    if start is None or len(motion) < 2:
        return motion, heights
    speed = np.linalg.norm(np.gradient(motion.root, 1 / motion.fps, axis=0), axis=-1)
    on_bed = (motion.root[:, 1] < goal[1] + OVER) & (np.arange(len(motion)) >= start)
    longer = np.where(on_bed, np.maximum(speed / MOST, 1.0), 1.0)
    if longer.max() == 1:
        return motion, heights
    longer = gaussian_filter1d(maximum_filter1d(longer, 2 * BESIDE + 1), SMOOTHED)
    at = np.concatenate([[0.0], np.cumsum((longer[1:] + longer[:-1]) / 2)])
    frames = np.interp(np.arange(int(at[-1]) + 1), at, np.arange(len(motion)))
    return motion.at_frames(frames), np.interp(frames, np.arange(len(motion)), heights)
