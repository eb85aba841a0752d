"""Bodies that hover over a mattress while they lie down: the pelvis is lowered onto it.

Now and then the network sits down above the edge of a bed, and reclines in the air before it comes to rest. Network
frame, metres; the floor is at height 0.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from .... import rotation, skeleton
from ....easing import smoothstep
from ....motion import Motion
from ....scene.seats.postures import to_pelvis
from .resting import RestingTop

LOWERED, STANDS = 0.16, 0.30
"""Metres over where it would rest up to which a pelvis is lowered entirely, and from which a body is on its feet."""

ENOUGH = 0.015
"""Metres over the mattress that are not seen."""

SIGMA = 4.0
"""Frames over which the lowering is smoothed."""


def lowered(motion: Motion, top: RestingTop) -> Motion:
    """Return the motion with its pelvis on the mattress from when it begins to lie down, at most LOWERED lower."""
    if motion.interaction_start is None:
        return motion
    turns = motion.forward_kinematics()[1][:, skeleton.INDEX["spine1"]]
    thick = to_pelvis(rotation.uprightness(turns))
    x, z, inside = top.cells(motion.root[:, [0, 2]])
    surface = top.heights[x, z]
    on = inside & (surface > top.low) & (surface < top.high)
    on &= np.arange(len(motion)) >= motion.interaction_start
    gap = np.where(on, motion.root[:, 1] - thick - np.where(on, surface, 0.0), 0.0)
    if gap.max() < ENOUGH:
        return motion
    down = np.maximum(gap, 0.0) * smoothstep((STANDS - gap) / (STANDS - LOWERED))
    down = gaussian_filter1d(down, SIGMA, mode="nearest")
    return replace(motion, root=motion.root - down[:, None] * [0.0, 1.0, 0.0])
