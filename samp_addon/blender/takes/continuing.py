"""What a take that continues from the current pose has to know: the pose, where it stands, and the motion so far."""

from __future__ import annotations

from dataclasses import dataclass, replace

import bpy
import numpy as np

from ... import frames, skeleton
from ...body import human, proportions
from ...methods.take import Take
from ...motion import Goal, Motion
from ...vocabulary import ACTIONS, SEATED
from ..actions import keyframes, notes
from ..character import armature, start
from ..character.start import Place

SAME_FLOOR = 0.2
"""Largest difference in metres between the stored start and the feet on the same floor."""
FEET = [skeleton.INDEX[f"{side}_foot"] for side in ("left", "right")]


@dataclass(frozen=True)
class Before:
    """The state that takes continue. Network frame, metres.

    pose: one frame, in the default proportions. place: the floor under it, and its facing. take: the motion up to the
    current frame where it is a take with contacts and actions, else None. frame: the scene's current frame.
    """

    pose: Motion
    place: Place
    take: Take | None
    frame: int


def read(context: bpy.types.Context, owner: bpy.types.Object) -> Before:
    """Read a character's current pose and, if its active Action is a take, the motion up to the current frame."""
    scene = context.scene
    rest = skeleton.default_rest_joints()
    pose = proportions.adapt(armature.posed(owner), rest)
    floor = _floor(owner, pose)
    place = pose.root[0].copy()
    place[1] = floor
    yaw = float(frames.direction_yaw(pose.headings()[0]))
    return Before(pose, (place, yaw), _take(scene, owner, pose, floor), scene.frame_current)


def before(owner: bpy.types.Object, motion: Motion, frame: int) -> Before:
    """Return the state at the end of a motion, in the owner's proportions, that ends in this frame of the scene."""
    rest = skeleton.default_rest_joints()
    # At 30 frames per second, and with the last frame exactly.
    count = int(motion.seconds * 30.0 + 1e-6) + 1
    at = len(motion) - 1 - np.arange(count)[::-1] * motion.fps / 30.0
    whole = proportions.adapt(replace(motion.at_frames(at), fps=30.0), rest)
    pose = whole.pose_slice(slice(-1, None))
    floor = _floor(owner, pose)
    place = pose.root[0] * [1.0, 0.0, 1.0] + [0.0, floor, 0.0]
    yaw = float(frames.direction_yaw(pose.headings()[0]))
    known = whole.contacts is not None and whole.actions is not None
    return Before(pose, (place, yaw), _so_far(whole, pose, floor) if known else None, frame)


def _take(scene: bpy.types.Scene, owner: bpy.types.Object, pose: Motion, floor: float) -> Take | None:
    """Return the take that ends in the current pose, in the default proportions at 30 frames per second."""
    action = owner.animation_data.action if owner.animation_data is not None else None
    if not notes.is_take(action):
        return None
    first, last = int(action.frame_range[0]), notes.take_end(action)
    now = min(scene.frame_current, last)
    if now < first:
        return None
    motion = keyframes.read_motion(owner, action, first, now, scene).resampled(30.0)
    if motion.contacts is None or motion.actions is None:
        return None
    return _so_far(proportions.adapt(motion, pose.rest_joints), pose, floor)


def _so_far(motion: Motion, pose: Motion, floor: float) -> Take:
    """Return a motion of 30 fps, in the default proportions, as the take that others go on from."""
    kind = ACTIONS[int(np.argmax(motion.actions[-1]))]
    under = pose.root[0] * [1.0, 0.0, 1.0] + [0.0, floor, 0.0]
    goal = Goal(motion.root[-1], motion.headings()[-1], kind) if kind in SEATED else None
    front = under if goal is None else _front(motion, pose) * [1.0, 0.0, 1.0] + [0.0, floor, 0.0]
    return Take(0, motion, goal=goal, waypoints=np.stack([under, front]))


def _front(motion: Motion, pose: Motion) -> np.ndarray:
    """Return where a seated character gets up (3,): where it began to sit down, else where its feet are."""
    begun = motion.interaction_start
    return pose.forward_kinematics()[0][0, FEET].mean(0) if begun is None else motion.root[begun]


def _floor(owner: bpy.types.Object, pose: Motion) -> float:
    """Return the height of the floor that the pose is on: the start's if it is near, else that of the lower foot."""
    joints = pose.forward_kinematics()[0][0]
    body = human.load()
    sole = float(body.joints[:, 1].min() - body.floor)
    lowest = float(joints[:, 1].min()) - sole
    stored = start.stored(owner)
    if stored is not None and abs(stored[0][1] - lowest) < SAME_FLOOR:
        return float(stored[0][1])
    return lowest


def views_after(views: list, before: Before | None, seeds: range) -> list:
    """Return the steps' views of a job; its first step goes on from the motion before, through sub-goals also from a
    pose without motion."""
    if before is None:
        return views
    take = before.take
    if take is None and len(views[0].sub_goals):
        take = Take(0, before.pose, waypoints=before.place[0][None])
    if take is None:
        return views
    after = {seed: replace(take, seed=seed) for seed in seeds}
    return [replace(views[0], after=after), *views[1:]]
