"""The middle of the hips of a body, and how far it is from the skin that the body sits on."""

from __future__ import annotations

import numpy as np

from ... import skeleton
from ...body.proportions import leg_length

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
