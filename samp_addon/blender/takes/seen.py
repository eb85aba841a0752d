"""What Blender shows of a take: the evaluated pose, where more than the take's Action moves the character.

NLA strips, constraints, drivers and parents are evaluated by Blender only. Where there are none, the f-curves are what
is shown, and no frame has to be evaluated.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import bpy
import numpy as np

from ... import frames, rotation
from ...errors import SampError
from ...motion import Motion
from .. import compat
from ..actions import keyframes
from ..actions.keyframes import Reader

LOOKED_AT = (0, 5, 20, 60, 150, 300)
"""Frames after the scene's first one in which furniture and characters must not have moved."""

STILL = 0.02
"""Metres, and radians, of movement that does no harm."""

OFF = 0.02
"""Metres between the Action's pelvis and the shown one that are worth a warning."""

_TRANSFORMS = ("location", "rotation", "scale", "delta_")


def require_still(
    context: bpy.types.Context, owner: bpy.types.Object | None, targets: Sequence[bpy.types.Object] = ()
) -> None:
    """Raise SampError where the character's object (not its bones) or a target is moved while the take would run.

    Frames are evaluated only where something could move one of them.
    """
    moved = [(obj, mover(obj, obj is not owner)) for obj in (owner, *targets) if obj is not None]
    moved = [(obj, reason) for obj, reason in moved if reason]
    if not moved:
        return
    with frame_kept(context.scene):
        first = context.scene.frame_start
        context.scene.frame_set(first)
        before = {obj.name: _world(context, obj) for obj, _ in moved}
        for frame in LOOKED_AT[1:]:
            context.scene.frame_set(first + frame)
            for obj, reason in moved:
                away = np.abs(_world(context, obj) - before[obj.name]).max()
                if away > STILL:
                    raise SampError(
                        f"'{obj.name}' moves between frames {first} and {first + frame}, by {reason}; "
                        "mute or apply that, so that it stands still, and start again."
                    )


def shown_motion(
    context: bpy.types.Context, owner: bpy.types.Object, action: bpy.types.Action
) -> tuple[Motion, list[str]]:
    """Return the Motion that Blender shows of an Action, and a sentence if that is not what its keys say."""
    keyed = keyframes.read_motion(owner, action, scene=context.scene)
    reason = influence(owner)
    if reason is None:
        return keyed, []
    start = int(np.floor(action.frame_range[0]))
    with frame_kept(context.scene), _shown_alone(owner, action):
        reader = SeenPose(context, owner, np.arange(start, start + len(keyed)))
    pose = keyframes.read_motion(owner, action, scene=context.scene, reader=reader)
    motion = _carried(pose, reader.world, np.array(owner.matrix_world, dtype=np.float64))
    off = float(np.linalg.norm(motion.root - keyed.root, axis=-1).max())
    if off < OFF:
        return motion, []
    return motion, [f"Blender shows the body up to {off:.2f} m from where its keys put it, by {reason}."]


class SeenPose(Reader):
    """The evaluated pose of an armature at some frames, in place of f-curves. world: (T, 4, 4) of its object."""

    def __init__(self, context: bpy.types.Context, owner: bpy.types.Object, times: np.ndarray) -> None:
        self.pose, self.times = owner.pose.bones, times
        names = [bone.name for bone in owner.pose.bones]
        self._own = {name: np.empty((len(times), 4, 4)) for name in names}
        self.world = np.empty((len(times), 4, 4))
        for k, frame in enumerate(times):
            context.scene.frame_set(int(frame))
            shown = owner.evaluated_get(context.evaluated_depsgraph_get())
            self.world[k] = shown.matrix_world
            for name in names:
                bone = shown.pose.bones[name]
                self._own[name][k] = shown.convert_space(
                    pose_bone=bone, matrix=bone.matrix, from_space="POSE", to_space="LOCAL"
                )

    def values(self, bone: str, path: str, size: int) -> np.ndarray:
        """Return the location of a bone over the frames, (T, 3)."""
        if path != "location":
            raise ValueError(f"{path} is not read from an evaluated pose")
        return self._own[bone][:, :3, 3]

    def quaternions(self, bone: str) -> np.ndarray:
        """Return a bone's own rotation over the frames, (T, 4)."""
        matrices = self._own[bone][:, :3, :3]
        length = np.linalg.norm(matrices, axis=1, keepdims=True)
        return rotation.matrix_to_quaternion(matrices / np.maximum(length, 1e-9))


def _carried(motion: Motion, worlds: np.ndarray, now: np.ndarray) -> Motion:
    """Return a motion, read with its armature at ``now`` (4, 4), as carried by the armature's matrices (T, 4, 4)."""
    if np.abs(worlds - now).max() < 1e-6:
        return motion
    moves = worlds @ np.linalg.inv(now)
    turn = frames.BLENDER_FROM_NETWORK.T @ moves[:, :3, :3] @ frames.BLENDER_FROM_NETWORK
    root = np.einsum("tij,tj->ti", moves[:, :3, :3], frames.to_blender(motion.root)) + moves[:, :3, 3]
    rotations = motion.rotations.copy()
    rotations[:, 0] = rotation.multiply(rotation.matrix_to_quaternion(turn), rotations[:, 0])
    return Motion(
        frames.to_network(root), rotation.continuous(rotations), motion.fps, motion.contacts, motion.actions,
        motion.rest_joints, motion.interaction_start,
    )  # fmt: skip


def mover(obj: bpy.types.Object, with_action: bool) -> str | None:
    """Return what could move an object, in words, or None. with_action: whether its own active Action counts."""
    reason = _own_mover(obj, with_action)
    parent = obj.parent
    while reason is None and parent is not None:
        if _own_mover(parent, True) or obj.parent_type == "BONE":
            reason = f"its parent '{parent.name}'"
        parent = parent.parent
    return reason


def _own_mover(obj: bpy.types.Object, with_action: bool) -> str | None:
    """Return what could move an object itself, in words, or None."""
    data = obj.animation_data
    if data is not None:
        if _has_strips(data):
            return "a strip in its NLA"
        if any(driver.data_path.startswith(_TRANSFORMS) for driver in data.drivers):
            return "a driver"
        if with_action and data.action is not None:
            return f"the Action '{data.action.name}'"
    for constraint in obj.constraints:
        if not constraint.mute and constraint.influence > 0:
            return f"its constraint '{constraint.name}'"
    if obj.rigid_body is not None and obj.rigid_body.type == "ACTIVE":
        return "a rigid body simulation"
    return None


def influence(owner: bpy.types.Object) -> str | None:
    """Return what besides the active Action changes what is shown of an armature, in words, or None."""
    reason, data = mover(owner, False), owner.animation_data
    if reason is not None:
        return reason
    if data is not None:
        if any(driver.data_path.startswith("pose.") for driver in data.drivers):
            return "a driver"
        if data.action is not None and (data.action_blend_type != "REPLACE" or data.action_influence < 1):
            return "the Action's blending or influence"
    for bone in owner.pose.bones:
        for constraint in bone.constraints:
            if not constraint.mute and constraint.influence > 0:
                return f"the constraint '{constraint.name}' of its bone '{bone.name}'"
    return None


def _has_strips(data: bpy.types.AnimData) -> bool:
    return data.use_nla and any(not track.mute and len(track.strips) for track in data.nla_tracks)


def _world(context: bpy.types.Context, obj: bpy.types.Object) -> np.ndarray:
    """Return the evaluated matrix (4, 4) of an object."""
    return np.array(obj.evaluated_get(context.evaluated_depsgraph_get()).matrix_world, dtype=np.float64)


@contextmanager
def frame_kept(scene: bpy.types.Scene) -> Iterator[None]:
    """Return to the present frame afterwards."""
    frame, part = scene.frame_current, scene.frame_subframe
    try:
        yield
    finally:
        scene.frame_set(frame, subframe=part)


@contextmanager
def _shown_alone(owner: bpy.types.Object, action: bpy.types.Action) -> Iterator[None]:
    """Make an Action the active one for a while."""
    data = owner.animation_data
    before = None if data is None else data.action
    slot = getattr(data, "action_slot", None) if before is not None else None
    compat.assign(owner, action)
    try:
        yield
    finally:
        if before is None:
            owner.animation_data.action = None
        elif before != action:
            compat.assign(owner, before, slot)
