"""Hands of a seated body on its lap: where the posture asks for it, and instead of hands that hang in the air.

Few captured people sit still with their hands in their lap, and those who gesticulate end a take with raised hands.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from .... import rotation, skeleton
from ....easing import smoothstep
from ....motion import Motion
from ....refine.inverse_kinematics import solve_limb

ALONG = 0.6  # share of the way from hip to knee at which a wrist lies
OVER = 0.10  # metres from the axis of a thigh up to the joint of a wrist on it
RAISED = 0.30  # metres from the pelvis up from which a hand hangs in the air
HELD = 20  # last frames at 30 fps over which the heights of hands are averaged
DURATION, EARLY = 36.0, 4  # frames over which hands are lowered, and before the pelvis is down
ELSEWHERE = ("hands_on_armrests", "hands_on_table")


def lowered(motion: Motion, seated: int, posture: Collection[str]) -> Motion:
    """Return the motion with hands on the lap at its end.

    seated: frame from which the pelvis is down. posture: of the rest; with hands elsewhere nothing changes.
    """
    if set(ELSEWHERE) & set(posture) or len(motion) - seated < HELD:
        return motion
    positions, _ = motion.forward_kinematics()
    duration = min(DURATION, len(motion) - seated + EARLY - 6)
    weight = smoothstep((np.arange(len(motion)) - seated + EARLY) / duration)[:, None]
    rotations = motion.rotations
    for side in ("left", "right"):
        hip, knee, wrist = (
            positions[:, skeleton.INDEX[f"{side}_{name}"]] for name in ("hip", "knee", "wrist")
        )
        raised = (wrist[-HELD:, 1] - motion.root[-HELD:, 1]).mean() > RAISED
        if not (raised or "hands_on_lap" in posture):
            continue
        lap = hip + ALONG * (knee - hip) + np.array([0.0, OVER, 0.0])
        rotations = solve_limb(
            motion.root, rotations, motion.rest_joints, f"{side}_arm", wrist + weight * (lap - wrist)
        )
        # The hand follows the forearm, instead of keeping the turn that it had in the air.
        at = skeleton.INDEX[f"{side}_wrist"]
        rest = np.broadcast_to([1.0, 0.0, 0.0, 0.0], rotations[:, at].shape)
        rotations = rotations.copy()
        rotations[:, at] = rotation.slerp(rotations[:, at], rest, weight[:, 0])
    return replace(motion, rotations=rotations)
