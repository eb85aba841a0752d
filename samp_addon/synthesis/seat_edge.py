"""How far a body has to stand in front of a deep seat before it can sit back into it.

The captured sits are on stools: people stand with the seat against their calves, 20 cm in front of where the pelvis
will be. On a deep seat that place is inside the cushion. So the rollout is given a goal further forward, and the
pelvis goes back by the rest while it sinks, the feet staying where they stand.
"""

from __future__ import annotations

import numpy as np

from ..motion import Goal
from ..scene.geometry import sample_surface
from ..scene.postures import SEAT_TO_PELVIS

STANDS_AHEAD = (
    0.20  # metres from the standing to the seated pelvis in the captured sits, median 0.16, 90 % 0.22
)
CALF_BEHIND = 0.07  # metres from the standing pelvis back to the calves' skin
MOST = 0.30
_HALF_WIDTH, _SAMPLES = 0.16, 20000


def front_edge(triangles: np.ndarray, goal: Goal) -> float:
    """Metres from the goal's pelvis forward to the seat's front edge; 0 where nothing is ahead."""
    points, _ = sample_surface(triangles, _SAMPLES, seed=0)
    away = points - goal.position
    ahead = away @ goal.direction
    aside = np.abs(away @ np.array([goal.direction[2], 0.0, -goal.direction[0]]))
    level = np.abs(away[:, 1] + SEAT_TO_PELVIS) < 0.08
    strip = ahead[level & (aside < _HALF_WIDTH) & (ahead > 0) & (ahead < 0.6)]
    return float(np.percentile(strip, 98)) if len(strip) > 20 else 0.0


def stand_off(triangles: np.ndarray, goal: Goal) -> float:
    """Metres by which the goal of the rollout lies in front of the seated pelvis."""
    return float(np.clip(front_edge(triangles, goal) + CALF_BEHIND - STANDS_AHEAD, 0.0, MOST))
