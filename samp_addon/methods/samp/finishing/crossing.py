"""Crossed ankles of a seated body, where the posture asks for crossed legs: one foot steps over the other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .... import skeleton
from ....easing import smoothstep
from ....motion import Motion
from ....refine.feet.foot import FEET
from ....refine.inverse_kinematics import solve_limb

PAST, BEFORE = 0.07, 0.12  # metres by which one ankle is on the other's side, and in front of it
LIFT = 0.05  # metres by which the foot is raised on its way
DELAY, DURATION = 12, 30.0  # frames at 30 fps after the pelvis is down, and of the step
CROSSED = 0.03  # metres from which ankles are crossed already
FARTHEST = 0.45  # metres that a foot is moved


def crossed(motion: Motion, goal: np.ndarray, seated: int) -> Motion:
    """Return the motion with its ankles crossed at its end, unless there is no time or too long a way.

    goal: row of Route.goals. seated: frame from which the pelvis is down.
    """
    begin = seated + DELAY
    if len(motion) - begin < DURATION / 2:
        return motion
    duration = min(DURATION, len(motion) - begin - 1.0)
    positions, _ = motion.forward_kinematics()
    ahead = goal[3:6]
    left = np.cross([0.0, 1.0, 0.0], ahead)
    ankles = {side: positions[:, skeleton.INDEX[f"{side}_ankle"]] for side in ("left", "right")}
    apart = (ankles["left"] - ankles["right"])[-1]
    if apart @ left < -CROSSED:
        return motion
    # The foot that is farther ahead steps over the other one.
    side, sign = ("left", -1.0) if apart @ ahead > 0 else ("right", 1.0)
    own, other = ankles[side], ankles["right" if side == "left" else "left"]
    # The foot lock will pin the other foot at its mean place, whatever its drift.
    target = other[seated:].mean(0) + sign * PAST * left + BEFORE * ahead
    target[1] = own[seated:, 1].mean()
    if np.linalg.norm(target - own[-1]) > FARTHEST:
        return motion
    share = np.clip((np.arange(len(motion)) - begin) / duration, 0.0, 1.0)
    weight = smoothstep(share)[:, None]
    moved = own + weight * (target - own) + LIFT * np.sin(np.pi * share)[:, None] * np.array([0.0, 1.0, 0.0])
    rotations = solve_limb(motion.root, motion.rotations, motion.rest_joints, f"{side}_leg", moved)
    contacts = motion.contacts
    if contacts is not None:
        contacts = contacts.copy()
        column = next(foot.column for foot in FEET if foot.side == side)
        contacts[(share > 0) & (share < 1), column] = 0.0
    return replace(motion, rotations=rotations, contacts=contacts)
