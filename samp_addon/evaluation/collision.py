"""Penetration, non-collision and contact of a body with the scene's triangles. Network frame, metres.

The depth of a frame is the larger of two: of the body's vertices inside the scene's solids, to the nearest surface
(obstacles.py); and of the scene's surface inside the body, to the nearest skin (skin_depth.py), without which a thigh
that passes through a thin seat, a slat or a wire counts as free.
"""

from __future__ import annotations

import numpy as np

from ..body import human
from ..body.hands import complete
from ..motion import Motion
from ..scene.distance.point_cells import PointCells
from ..scene.geometry import extent
from ..skeleton import forward_kinematics
from .obstacles import ROUNDING, Obstacles
from .skin_depth import SkinSurface, surface_of

DEPTHS = (0.02, 0.05)
CHUNK = 32
"""Frames whose surroundings are sampled together."""

LARGEST_BOX = 6.0
"""Metres. Frames that span more are sampled in parts: takes can jump far."""

STRIDE = 3
"""Frames between two in which the surface is looked for in the body; in between, the deeper neighbour counts."""

CELL = 0.08
"""Metres along the edge of the cells into which samples are sorted."""

SAME_POSE = 0.004
"""Metres. A pose whose joints all moved less since the last measured frame has the same depth."""


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
    motion: Motion,
    obstacles: Obstacles,
    floor: float | None = None,
    body: human.Human | None = None,
    found: tuple[np.ndarray, np.ndarray] | None = None,
) -> dict[str, float]:
    """Compute penetration, non-collision and contact; arguments as for `body_depth`. found: its result, if known.

    Penetration: percentage of frames deeper than 2 and 5 cm, mean and maximum depth over frames, cm; the depth of a
    frame is that of its deepest vertex in the scene, or of the deepest surface sample in the body.
    Non-collision: share of vertices outside, mean over frames. Contact: share of frames that touch the scene.
    """
    depth, touching = found or body_depth(motion, obstacles, floor, body)
    deepest = np.maximum(depth.max(1), surface_depth(motion, obstacles, floor, body))
    numbers = {
        f"penetration_{limit * 100:.0f}cm_percent": float((deepest > limit).mean() * 100) for limit in DEPTHS
    }
    numbers["penetration_mean_cm"] = float(deepest.mean() * 100)
    numbers["penetration_max_cm"] = float(deepest.max() * 100)
    numbers["non_collision"] = float((depth <= ROUNDING).mean())
    numbers["contact"] = float(touching.any(1).mean())
    return numbers


def surface_depth(
    motion: Motion, obstacles: Obstacles, floor: float | None = None, body: human.Human | None = None
) -> np.ndarray:
    """Compute how deep the scene's surface is inside the body, to its nearest skin: (T,) metres, 0 where it is free.

    Arguments as for `body_depth`. The surface is sampled 1.5 cm apart where the take comes near.
    """
    body = body or human.load()
    surface = surface_of(body)
    joints = forward_kinematics(motion.root, complete(motion.rotations), body.joints)[0]
    result = np.zeros(len(motion))
    low, high = extent(joints)
    if (high - low).max() <= LARGEST_BOX:
        obstacles.samples(low - surface.reach, high + surface.reach, floor)  # sampled once for all parts
    pending = [(first, min(first + CHUNK, len(motion))) for first in range(0, len(motion), CHUNK)]
    while pending:
        first, last = pending.pop()
        low, high = extent(joints[first:last])
        if (high - low).max() > LARGEST_BOX and last - first > 1:
            middle = (first + last) // 2
            pending += [(first, middle), (middle, last)]
            continue
        samples = obstacles.samples(low - surface.reach, high + surface.reach, floor)
        if len(samples):
            rows = slice(first, last)
            result[rows] = _depth_of_samples(motion.pose_slice(rows), joints[rows], samples, surface, body)
    return result


def _depth_of_samples(
    motion: Motion, joints: np.ndarray, samples: np.ndarray, surface: SkinSurface, body: human.Human
) -> np.ndarray:
    """Return the largest depth (T,) of samples (N, 3) in the body; joints: (T, J, 3)."""
    depth = np.zeros(len(motion))
    measured = np.unique([*range(0, len(motion), STRIDE), len(motion) - 1])
    like, same = {}, None  # for each frame, the one whose depth it has: long holds are measured once
    for k in measured.tolist():
        if same is None or np.abs(joints[k] - joints[same]).max() >= SAME_POSE:
            same = k
        like[k] = same
    cells = PointCells(samples, CELL)
    close = {k: surface.near(joints[k], samples, cells) for k in dict.fromkeys(like.values())}
    frames = np.array([k for k, near in close.items() if len(near)], int)
    if not len(frames):
        return depth
    skin = human.skin(body, motion.pose_slice(frames), surface.vertices)
    for vertices, k in zip(skin, frames.tolist(), strict=True):
        depth[k] = surface.deepest(vertices, samples[close[k]], joints[k])
    depth[list(like)] = depth[list(like.values())]
    frames = np.arange(len(motion))
    before = np.searchsorted(measured, frames, side="right") - 1
    after = np.minimum(before + 1, len(measured) - 1)
    between = np.where(measured[before] == frames, 0.0, depth[measured[after]])
    return np.maximum(depth[measured[before]], between)
