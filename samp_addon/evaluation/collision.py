"""Penetration, non-collision and contact of a body with the scene's triangles. Network frame, metres.

What is solid, and how far a vertex is from its surface, says obstacles.py.
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
    """How deep the body's 2048 collision vertices lie inside the scene, and which touch it.

    floor: height under which all is solid, or None. The body of the first frame counts as outside of all. Returns
    depth (T, 2048) in metres, 0 outside, and touching (T, 2048): flags of vertices less than 1 cm from a surface, or
    inside.
    """
    body = body or human.load()
    return obstacles.depth(human.skin(body, motion, body.collision), floor)


def measures(
    motion: Motion, obstacles: Obstacles, floor: float | None = None, body: human.Human | None = None
) -> dict[str, float]:
    """Penetration: % of frames with a vertex deeper than 2 and 5 cm, mean and largest of the frames' depths
    in cm; non-collision: share of vertices outside, mean over frames; contact: share of frames that touch."""
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
