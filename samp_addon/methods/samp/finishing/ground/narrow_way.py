"""Bodies in narrow gaps, as between two rows of seats: kept where they pass. Network frame, metres."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from .....motion import Motion

FreeFloor = Callable[[np.ndarray], np.ndarray]
"""Returns the places (N, 3) nearest to floor points (N, 3) at which a body does not stand in other things."""

HOLD, SIGMA = 9, 5.0
"""Frames at 30 fps over which the largest nearby shift is held, and of the Gaussian over it: no sudden side steps."""


def keep_on(motion: Motion, free: FreeFloor | None, weight: np.ndarray) -> Motion:
    """Return a motion whose pelvis stays over free floor; unchanged where it does already.

    weight: (T,) 1 where the body walks, 0 where it sits. Feet slide by as much as the body is moved, so that they are
    locked afterwards.
    """
    if free is None:
        return motion
    missing = (free(motion.root) - motion.root)[:, [0, 2]] * weight[:, None]
    scale = motion.fps / 30
    size = max(int(HOLD * scale), 1)
    smooth = lambda values: gaussian_filter1d(values, SIGMA * scale, axis=0, mode="nearest")
    pushed, pulled = maximum_filter1d(missing, size, axis=0), -maximum_filter1d(-missing, size, axis=0)
    offset = smooth(np.maximum(pushed, 0) + np.minimum(pulled, 0))
    return replace(motion, root=motion.root + np.stack([offset[:, 0], 0 * offset[:, 0], offset[:, 1]], -1))
