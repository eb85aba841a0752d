"""The raised back of a lounger or recliner, on which the trunk of a lying body rests.

Captured bodies lie flat. On a raised back the trunk is turned up about the pelvis to the angle of the back; the legs
keep their place. A trunk that is steeper, as while sitting down, does not change.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from .... import rotation, skeleton
from ....easing import anticipate, smoothstep
from ....motion import Motion

REACH = 1.3  # horizontal metres around the goal within which trunks are raised
TOWARDS = 0.6  # share of the trunk's horizontal direction towards the head end at which it is raised entirely
WINDOW, SIGMA = 9, 4.0  # frames over which the turn begins early, and is smoothed


def raise_trunk(motion: Motion, goal: np.ndarray, angle: float) -> Motion:
    """Return the motion with the trunk nowhere flatter than the back at the head end.

    goal: row of Route.goals. angle: radians of the back over the horizontal.
    """
    positions, globals_ = motion.forward_kinematics()
    trunk = positions[:, skeleton.INDEX["neck"]] - positions[:, 0]
    length = np.linalg.norm(trunk, axis=-1)
    flat = gaussian_filter1d(trunk[:, [0, 2]], SIGMA, axis=0, mode="nearest")
    flat = flat - 1e-3 * goal[[3, 5]]  # upright trunks have no direction of their own
    flat /= np.linalg.norm(flat, axis=-1, keepdims=True)
    near = np.linalg.norm(motion.root[:, [0, 2]] - goal[[0, 2]], axis=-1) < REACH
    weight = smoothstep(-(flat @ goal[[3, 5]]) / TOWARDS)
    missing = np.where(near, weight * np.maximum(angle - np.arcsin(trunk[:, 1] / length), 0.0), 0.0)
    if not missing.any():
        return motion
    missing = anticipate(missing, WINDOW, SIGMA)
    # About the horizontal axis on which the trunk turns upwards.
    axis = np.column_stack([-flat[:, 1], np.zeros(len(flat)), flat[:, 0]])
    turn = rotation.from_axis_angle(missing[:, None] * axis)
    rotations = motion.rotations.copy()
    rotations[:, 0] = rotation.multiply(turn, rotations[:, 0])
    for side in ("left", "right"):
        hip = skeleton.INDEX[f"{side}_hip"]
        rotations[:, hip] = rotation.multiply(rotation.conjugate(rotations[:, 0]), globals_[:, hip])
    return replace(motion, rotations=rotations)
