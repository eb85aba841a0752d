"""Getting up from a bed: lying down, played backwards, up to where the body stood beside the bed.

Asked to go from a bed to a seat, MotionNet glides there through the air: in its training, bodies that get up have a
place to stand beside the bed as their goal, never the next seat. Its way of lying down is right, and fits the bed that
the body lies on. Network frame, metres.
"""

from __future__ import annotations

import numpy as np

from .. import rotation, skeleton
from ..motion import Motion
from .take import Take

STANDS = 0.9
"""Share of the pelvis' height in standing from which a body stands."""

UPRIGHT = 0.9
"""Cosine between chest and vertical from which it does."""

LOOKED_BACK = 30
"""Frames before it begins to lie down in which the slowest one is looked for: there the direction of time is not
seen."""

RESTS = 0.03
"""Metres from its place at the end within which each joint of a resting body stays."""

CHEST = skeleton.INDEX["spine3"]


def from_bed(before: Take, standing: float) -> Motion | None:
    """Return how the body at the end of a take gets up; None where it does not lie there, or lay from the start.

    standing: height of the pelvis in standing.
    """
    motion = before.motion
    if before.goal is None or before.goal.action != "lie" or motion.actions is None:
        return None
    positions, turns = motion.forward_kinematics()
    upright = rotation.uprightness(turns[:, CHEST])
    stands = (motion.root[:, 1] - before.floor_end[1] > STANDS * standing) & (upright > UPRIGHT)
    if not stands.any() or stands[-1]:
        return None
    last = int(np.flatnonzero(stands)[-1])
    first = max(0, last - LOOKED_BACK)
    speed = np.linalg.norm(np.gradient(motion.root, axis=0), axis=-1) if len(motion) > 1 else np.zeros(1)
    from_here = first + int(speed[first : last + 1].argmin())
    away = np.linalg.norm(positions - positions[-1], axis=-1).max(1)
    rests = int(np.flatnonzero(away > RESTS)[-1]) + 1
    return motion.picked(np.arange(min(rests, len(motion) - 1), from_here - 1, -1))
