"""The pelvis while a body sits down: not in the seat, and not behind its goal in the back of it.

The network lets bodies drop a little too deep and too far back before they come to rest. Network frame, metres.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ....easing import anticipate
from ....motion import Motion

NEAR = 0.45
"""Horizontal metres from the goal within which a pelvis is over the seat."""

GIVE = 0.015
"""Metres that flesh and cushions yield."""

OVER = 0.3
"""Metres over the seated pelvis up to which a body is sitting down."""

WINDOW, SIGMA = 11, 3.0
"""Frames over which corrections begin early, and are smoothed."""


def kept_on(motion: Motion, goal: np.ndarray) -> Motion:
    """Return the motion with its pelvis on the seat and in front of its back. goal: row of Route.goals."""
    away = motion.root - goal[:3]
    near = (np.hypot(away[:, 0], away[:, 2]) < NEAR) & (away[:, 1] < OVER)
    behind = np.where(near, np.maximum(-(away * goal[3:6]).sum(-1) - GIVE, 0.0), 0.0)
    below = np.where(near, np.maximum(-away[:, 1] - GIVE, 0.0), 0.0)
    if not (behind.any() or below.any()):
        return motion
    forward, up = (anticipate(values, WINDOW, SIGMA)[:, None] for values in (behind, below))
    return replace(motion, root=motion.root + forward * goal[3:6] + up * [0.0, 1.0, 0.0])
