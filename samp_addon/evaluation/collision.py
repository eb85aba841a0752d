"""Penetration, non-collision and contact of a body with the scene's triangles. Network frame, metres.

Solid regions and distances to their surfaces are computed in obstacles.py.
"""

from __future__ import annotations

import numpy as np

from ..body import human
from ..motion import Motion
from .obstacles import ROUNDING, Obstacles

DEPTHS = (0.02, 0.05)


def body_depth(
    motion: Motion, obstacles: Obstacles, floor: float | None = None, body: human.Human | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Compute the depth of the body's 2048 collision vertices inside the scene, and which of them touch it.

    floor: height below which everything is solid, metres, or None. body: the default human if left out. The body of the
    first frame is assumed to be outside all solids. Returns depth (T, 2048), metres, 0 outside, and touching (T, 2048):
    flags of vertices inside or less than 1 cm from a surface.
    """
    body = body or human.load()
    return obstacles.depth(human.skin(body, motion, body.collision), floor)


def measures(
    motion: Motion, obstacles: Obstacles, floor: float | None = None, body: human.Human | None = None
) -> dict[str, float]:
    """Compute penetration, non-collision and contact; arguments as for `body_depth`.

    Penetration: percentage of frames with a vertex deeper than 2 and 5 cm, mean and maximum depth over frames, cm.
    Non-collision: share of vertices outside, mean over frames. Contact: share of frames that touch the scene.
    """
    depth, touching = body_depth(motion, obstacles, floor, body)
    deepest = depth.max(1)
    numbers = {
        f"penetration_{limit * 100:.0f}cm_percent": float((deepest > limit).mean() * 100) for limit in DEPTHS
    }
    numbers["penetration_mean_cm"] = float(deepest.mean() * 100)
    numbers["penetration_max_cm"] = float(deepest.max() * 100)
    numbers["non_collision"] = float((depth <= ROUNDING).mean())
    numbers["contact"] = float(touching.any(1).mean())
    return numbers
