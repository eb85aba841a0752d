"""The ground under a rig in its rest pose."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .. import skeleton
from ..body.proportions import leg_length
from ..refine.feet.foot import BALL_HEIGHT
from .rig import Rig

SOLE = (0.02, 0.3)  # least and greatest height of an ankle over the sole, in lengths of a leg
NEAR_FOOT = 0.35  # horizontal distance from an ankle within which its sole is searched, in lengths of a leg


def ground_height(
    rig: Rig, at: Mapping[str, int], axes: np.ndarray, places: Mapping[str, np.ndarray], skin: np.ndarray
) -> float:
    """Return the height of the ground under a rig in its rest pose, relative to the head of the pelvis bone, metres.

    It is that of the lowest skin of the feet, else of the armature's origin, else as far below the balls of the feet as
    in the default human. places: joint -> (3,). skin: (N, 3), in the frame of the places.
    """
    ankles = np.array([places[f"{side}_ankle"] for side in ("left", "right")])
    hips = np.array([places[f"{side}_hip"] for side in ("left", "right")])
    leg = float(np.linalg.norm(hips - ankles, axis=1).mean())
    low, high = (ankles[:, 1].mean() - share * leg for share in reversed(SOLE))
    if len(skin):
        away = np.linalg.norm((skin[:, None] - ankles)[..., [0, 2]], axis=-1).min(1)
        near = skin[(away < NEAR_FOOT * leg) & (skin[:, 1] < ankles[:, 1].mean())]
        if len(near) and low < near[:, 1].min() < high:
            return float(near[:, 1].min())
    balls = [places[joint][1] for joint in ("left_foot", "right_foot") if joint in places]
    origin = float(-(rig.heads[at["pelvis"]] @ axes[:, 1]) * rig.scale)
    if low < origin < high and all(origin < ball + 0.02 * leg for ball in balls):
        return origin
    own = leg / leg_length(skeleton.default_rest_joints())
    return float(min(balls, default=ankles[:, 1].mean() - 0.05 * own) - BALL_HEIGHT * own)
