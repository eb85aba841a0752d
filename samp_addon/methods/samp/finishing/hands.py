"""Hands of a seated body, where the posture asks for them: on the lap, the armrests or a table, and not in the air.

Few captured people sit still with their hands in their lap, and those who gesticulate end a take with raised hands.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from .... import rotation, skeleton
from ....easing import settling, smoothstep
from ....motion import Motion
from ....refine.inverse_kinematics import solve_limb
from .leaning import leaned
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
REACHED = 0.82
"""Share of the length of an arm up to which it is stretched towards a table; the trunk does the rest."""
STOOP = np.radians(22.0)
"""Largest turn of the trunk towards a table."""
FIRST_UP, THEN_AHEAD = 0.6, 0.4
"""Share of the time in which hands rise over the edge of a table, and from which they move forward onto it."""


def rested(
    motion: Motion,
    goal: np.ndarray,
    seated: int,
    posture: Collection[str],
    top: RestingTop | None,
    table: np.ndarray | None = None,
) -> Motion:
    """Return the motion with its hands at rest at its end.

    goal: row of Route.goals. seated: frame from which the pelvis is down. posture: of the rest. top: of the seat, for
    its armrests. table: places (2, 3) of the left and the right wrist on it; without them, hands on a table are left to
    the network. The floor of the motion is at height 0.
    """
    on_table = "hands_on_table" in posture
    if (on_table and table is None) or len(motion) - seated < HELD:
        return motion
    weight = settling(len(motion), seated, DURATION, EARLY)[:, None]
    if on_table:
        motion = leaned(motion, goal[3:6], -_stoop(motion, goal, table) * weight[:, 0])
    positions, _ = motion.forward_kinematics()
    rotations = motion.rotations
    for number, side in enumerate(("left", "right")):
        hip, knee, wrist = (positions[:, skeleton.INDEX[f"{side}_{n}"]] for n in ("hip", "knee", "wrist"))
        raised = (wrist[-HELD:, 1] - motion.root[-HELD:, 1]).mean() > RAISED
        target, share = None, weight
        if on_table:
            target, share = table[number], _over_the_edge(weight)
        elif "hands_on_armrests" in posture and top is not None:
            target = armrest(top, goal, side)
        elif raised or "hands_on_lap" in posture:
            target = hip + ALONG * (knee - hip) + np.array([0.0, OVER, 0.0])
        if target is None:
            continue
        rotations = solve_limb(
            motion.root, rotations, motion.rest_joints, f"{side}_arm", wrist + share * (target - wrist)
        )
        # The hand follows the forearm, instead of keeping the turn that it had in the air.
        at = skeleton.INDEX[f"{side}_wrist"]
        rest = np.broadcast_to([1.0, 0.0, 0.0, 0.0], rotations[:, at].shape)
        rotations = rotations.copy()
        rotations[:, at] = rotation.slerp(rotations[:, at], rest, weight[:, 0])
    return replace(motion, rotations=rotations)


def _stoop(motion: Motion, goal: np.ndarray, table: np.ndarray) -> float:
    """Return the angle, radians, by which a trunk turns forward so that bent arms reach a table at the end.

    goal: row of Route.goals. table: places (2, 3) of the wrists.
    """
    joints = motion.pose_slice(slice(-HELD, None)).forward_kinematics()[0].mean(0)
    hips = joints[[skeleton.INDEX["left_hip"], skeleton.INDEX["right_hip"]]].mean(0)
    missing, over = 0.0, 0.1
    for place, side in zip(table, ("left", "right"), strict=True):
        shoulder, elbow, wrist = (skeleton.INDEX[f"{side}_{name}"] for name in ("shoulder", "elbow", "wrist"))
        arm = np.linalg.norm(np.diff(motion.rest_joints[[shoulder, elbow, wrist]], axis=0), axis=-1).sum()
        reach = place - joints[shoulder]
        aside = np.sum((reach - (reach @ goal[3:6]) * goal[3:6]) ** 2)
        ahead = np.sqrt(max((REACHED * arm) ** 2 - aside, 0.0))
        missing = max(missing, float(reach @ goal[3:6]) - ahead)
        over = max(over, float((joints[shoulder] - hips)[1]))
    # Rounded: takes must not depend on the number of threads.
    return round(float(np.clip(np.arcsin(np.clip(missing / over, 0.0, 1.0)), 0.0, STOOP)), 4)


def _over_the_edge(weight: np.ndarray) -> np.ndarray:
    """Return shares (T, 3) of the way of hands onto a table for weights (T, 1) over time: they rise before they move
    forward."""
    ahead = smoothstep((weight - THEN_AHEAD) / (1 - THEN_AHEAD))
    return np.concatenate([ahead, smoothstep(weight / FIRST_UP), ahead], axis=1)


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
