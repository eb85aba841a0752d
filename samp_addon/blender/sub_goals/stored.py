"""What is stored with a sub-goal: its body, how that was drawn, whether it is pinned, and why none fits.

The pose is relative to the arrow, so that it is saved, copied and undone with the scene.
"""

from __future__ import annotations

import bpy
import numpy as np

from ... import rotation
from ...motion import Motion
from ...vocabulary import CONTACTS, SEATED
from . import arrows, ghosts

POSE_KEY = "samp_sub_goal_pose"
"""Custom property of an arrow: pelvis position (3) and quaternions (22 or 55 x 4) in the axes of its spot."""
ACTION_KEY = "samp_sub_goal_action"
DRAW_KEY = "samp_sub_goal_draw"
"""Custom property of an arrow: the number of its draw."""
STYLE_KEY = "samp_sub_goal_style"
PINNED_KEY = "samp_sub_goal_pinned"
FITTED_KEY = "samp_sub_goal_fitted"
"""Custom property of an arrow: its world matrix (16) when the body was fitted."""
PROBLEM_KEY = "samp_sub_goal_problem"
"""Custom property of an arrow: why no body fits there; missing where one does."""
STILL = 1e-5
"""Largest change of an entry of a matrix that is no movement."""


def is_pinned(arrow: bpy.types.Object) -> bool:
    """Return whether the body of a sub-goal is kept."""
    return bool(arrow.get(PINNED_KEY, False))


def pin(arrow: bpy.types.Object, pinned: bool = True) -> None:
    """Keep the body of a sub-goal as it is, also where the arrow is moved, or let it be drawn again."""
    arrow[PINNED_KEY] = pinned
    if PROBLEM_KEY not in arrow:
        ghosts.colour(arrow, "pinned" if pinned else "body")


def problem(arrow: bpy.types.Object) -> str:
    """Return why no body fits at a sub-goal; empty where one does."""
    return str(arrow.get(PROBLEM_KEY, ""))


def is_stale(arrow: bpy.types.Object) -> bool:
    """Return whether a sub-goal was moved, or copied, since its body was fitted."""
    fitted = arrow.get(FITTED_KEY)
    if fitted is None or len(fitted) != 16 or (ghosts.find(arrow) is None and not problem(arrow)):
        return True
    flat = [value for row in arrow.matrix_world for value in row]
    return any(abs(a - b) > STILL for a, b in zip(flat, fitted, strict=True))


def store(context: bpy.types.Context, arrow: bpy.types.Object, pose: Motion, action: str) -> None:
    """Store a pose (one frame, network frame) with an arrow and show it as the ghost."""
    spot = arrows.read(arrow)
    back = rotation.about_y(-spot.yaw)
    turns = pose.rotations[0].copy()
    turns[0] = rotation.multiply(back, turns[0])
    root = rotation.rotate(back, pose.root[0] - spot.point)
    arrow[POSE_KEY] = [*map(float, root), *map(float, turns.ravel())]
    arrow[ACTION_KEY], arrow[FITTED_KEY] = action, matrix(arrow)
    if PROBLEM_KEY in arrow:
        del arrow[PROBLEM_KEY]
    ghosts.show(context, arrow, body(arrow), "pinned" if is_pinned(arrow) else "body")


def refuse(context: bpy.types.Context, arrow: bpy.types.Object, reason: str) -> None:
    """Store why no body fits at a sub-goal, and show the one that it had before in another colour."""
    arrow[PROBLEM_KEY], arrow[FITTED_KEY] = reason, matrix(arrow)
    if ghosts.find(arrow) is not None:
        ghosts.colour(arrow, "misplaced")


def body(arrow: bpy.types.Object) -> Motion:
    """Return the body of an arrow where it is now: one frame, default proportions, network frame."""
    spot, numbers = arrows.read(arrow), np.array(arrow[POSE_KEY], dtype=np.float64)
    ahead = rotation.about_y(spot.yaw)
    turns = numbers[3:].reshape(-1, 4).copy()
    turns[0] = rotation.multiply(ahead, turns[0])
    contacts = np.zeros((1, len(CONTACTS)))
    contacts[0, CONTACTS.index("pelvis")] = arrow.get(ACTION_KEY) in SEATED
    root = rotation.rotate(ahead, numbers[:3]) + spot.point
    return Motion(root[None], turns[None], contacts=contacts)


def matrix(arrow: bpy.types.Object) -> list[float]:
    """Return the 16 entries of an arrow's world matrix, row by row."""
    return [float(value) for row in arrow.matrix_world for value in row]
