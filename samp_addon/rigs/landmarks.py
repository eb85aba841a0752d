"""Landmarks of a body: the middle of its hips, the skin that it sits on, the ground under it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .. import skeleton
from ..body.proportions import leg_length
from ..refine.feet.foot import BALL_HEIGHT
from .rig import Rig

SOLE = (0.02, 0.3)  # least and greatest height of an ankle over the sole, in lengths of a leg
NEAR_FOOT = 0.35  # horizontal distance from an ankle within which its sole is searched, in lengths of a leg
SEAT_BAND = (-0.25, 0.03)  # heights over the hips between which a body touches its seat, in lengths of a leg
SEAT_SIDE = 1.5  # sideways distance from the middle within which it does, in distances between the hip joints


def hips(joints: np.ndarray) -> np.ndarray:
    """Return the middle (..., 3) of the hip joints. joints: (..., J, 3)."""
    return (joints[..., skeleton.INDEX["left_hip"], :] + joints[..., skeleton.INDEX["right_hip"], :]) / 2


def seat_depth(skin: np.ndarray, joints: np.ndarray) -> float | None:
    """Return the metres from the middle of the hips back to the skin (N, 3) that rests on a seat, or None without skin.

    joints: (55, 3) in the T-pose, in the frame of the skin. When seated this depth is below the hips.
    """
    leg = leg_length(joints)
    left, right = (joints[skeleton.INDEX[f"{side}_hip"]] for side in ("left", "right"))
    away = skin - hips(joints)
    near = (np.abs(away[:, 0]) < SEAT_SIDE * max(abs(left[0] - right[0]), 0.1 * leg)) & (
        (away[:, 1] > SEAT_BAND[0] * leg) & (away[:, 1] < SEAT_BAND[1] * leg)
    )
    if near.sum() < 8:
        return None
    depth = float(-np.percentile(away[near, 2], 2))
    return depth if 0.02 * leg < depth < 0.5 * leg else None


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
