"""Hands of a seated body, where the posture asks for them: on the lap or on the armrests, and not in the air.

Few captured people sit still with their hands in their lap, and those who gesticulate end a take with raised hands.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from .... import rotation, skeleton
from ....easing import settling
from ....motion import Motion
from ....refine.inverse_kinematics import solve_limb
from .resting import RestingTop

ALONG = 0.6  # share of the way from hip to knee at which a wrist lies on the lap
OVER = 0.10  # metres from the axis of a thigh up to the joint of a wrist on it
RAISED = 0.30  # metres from the pelvis up from which a hand hangs in the air
HELD = 20  # last frames at 30 fps over which the heights of hands are averaged
DURATION, EARLY = 36.0, 4  # frames over which hands are lowered, and before the pelvis is down
ASIDE, AHEAD = (0.20, 0.42), (0.0, 0.26)  # metres from the pelvis in which an armrest is
RISES = (-0.08, 0.20)  # metres from the pelvis up to the top of an armrest
BEST = (0.27, 0.16)  # metres aside and ahead at which a wrist lies best
LATTICE = 0.02
WRIST = 0.035  # metres from the joint of a wrist to the skin below


def rested(
    motion: Motion, goal: np.ndarray, seated: int, posture: Collection[str], top: RestingTop | None
) -> Motion:
    """Return the motion with its hands at rest at its end.

    goal: row of Route.goals. seated: frame from which the pelvis is down. posture: of the rest; hands on a table are
    left to the network. top: of the seat, for its armrests. The floor of the motion is at height 0.
    """
    if "hands_on_table" in posture or len(motion) - seated < HELD:
        return motion
    positions, _ = motion.forward_kinematics()
    weight = settling(len(motion), seated, DURATION, EARLY)[:, None]
    rotations = motion.rotations
    for side in ("left", "right"):
        hip, knee, wrist = (positions[:, skeleton.INDEX[f"{side}_{n}"]] for n in ("hip", "knee", "wrist"))
        raised = (wrist[-HELD:, 1] - motion.root[-HELD:, 1]).mean() > RAISED
        target = None
        if "hands_on_armrests" in posture and top is not None:
            target = armrest(top, goal, side)
        elif raised or "hands_on_lap" in posture:
            target = hip + ALONG * (knee - hip) + np.array([0.0, OVER, 0.0])
        if target is None:
            continue
        rotations = solve_limb(
            motion.root, rotations, motion.rest_joints, f"{side}_arm", wrist + weight * (target - wrist)
        )
        # The hand follows the forearm, instead of keeping the turn that it had in the air.
        at = skeleton.INDEX[f"{side}_wrist"]
        rest = np.broadcast_to([1.0, 0.0, 0.0, 0.0], rotations[:, at].shape)
        rotations = rotations.copy()
        rotations[:, at] = rotation.slerp(rotations[:, at], rest, weight[:, 0])
    return replace(motion, rotations=rotations)


def armrest(top: RestingTop, goal: np.ndarray, side: str) -> np.ndarray | None:
    """Return the place (3,) of a wrist on the armrest at one side of a seat, None where there is none."""
    aside, ahead = (v.ravel() for v in np.meshgrid(np.arange(*ASIDE, LATTICE), np.arange(*AHEAD, LATTICE)))
    facing = goal[3:6]
    left = np.cross([0.0, 1.0, 0.0], facing) * (1.0 if side == "left" else -1.0)
    places = goal[:3] + aside[:, None] * left + ahead[:, None] * facing
    x, z, inside = top.cells(places[:, [0, 2]])
    height = top.heights[x, z]
    rise = height - goal[1]
    on = np.flatnonzero(inside & (rise > RISES[0]) & (rise < RISES[1]))
    if not len(on):
        return None
    best = on[np.argmin((aside[on] - BEST[0]) ** 2 + (ahead[on] - BEST[1]) ** 2)]
    return np.array([places[best, 0], height[best] + WRIST, places[best, 2]])
