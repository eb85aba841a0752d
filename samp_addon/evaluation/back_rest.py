"""The gap between a seated back and the back of the seat. Network frame, metres."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..body import human
from ..body.human import Human
from ..motion import Motion

TOUCHING = 0.03
"""Metres from the skin of the back to the seat's up to which a body leans on it: clothes and cushions yield."""

ABOVE, BEHIND, ASIDE = 0.10, 0.45, 0.2
"""Metres over, behind and aside of the pelvis in which a seat has a back."""

FEWEST = 10
"""Points on the seat's back below which it counts as having none."""

_TRUNK = (3, 6, 9)  # joints whose skin is the back


def gap(motion: Motion, frame: int, points: np.ndarray, body: Human | None = None) -> float | None:
    """Return the metres from the upper back to the back of a seat in one frame; None where the seat has no back.

    points: (N, 3) on the seat's surface, thousands. body: the default human if left out.
    """
    body = body or human.load()
    still = motion.pose_slice(slice(frame, frame + 1))
    away, ahead = points - still.root[0], still.headings()[0]
    behind = -(away @ ahead)
    aside = np.abs(away @ np.cross([0.0, 1.0, 0.0], ahead))
    back = points[(away[:, 1] > ABOVE) & (behind > 0) & (behind < BEHIND) & (aside < ASIDE)]
    if len(back) < FEWEST:
        return None
    owner = np.take_along_axis(body.weight_joints, body.weights.argmax(1)[:, None], 1)[:, 0]
    rear = np.isin(owner, _TRUNK) & (body.vertices[:, 2] < np.percentile(body.vertices[:, 2], 25))
    return float(cKDTree(back).query(human.skin(body, still)[0][rear])[0].min())
