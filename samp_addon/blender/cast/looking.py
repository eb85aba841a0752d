"""Look At for a take that is there already: the head of a character turned to an object, as a new Action."""

from __future__ import annotations

import bpy
import numpy as np

from ... import frames, skeleton
from ...edits.look_at import look_at
from ...errors import SampError
from ..actions import keyframes, rekeying
from ..character import armature
from ..takes import seen

HEAD = skeleton.INDEX["head"]


def bake(
    context: bpy.types.Context,
    target: bpy.types.Object,
    character: str = "",
    first: int | None = None,
    last: int | None = None,
    ease: float = 0.5,
) -> bpy.types.Action:
    """Turn a character's head to an object in some frames of its active Action; return the new Action, now active.

    first, last: frames of the scene; the Action's where left out. ease: seconds in which the head turns. Raise
    SampError where there is no character or Action, and for an empty range or the character itself as the target.
    """
    owner, action = keyframes.find_action(context, character)
    if target == owner or target.find_armature() == owner:
        raise SampError(f"'{owner.name}' cannot look at itself; choose another target.")
    keyframes.require_editable(owner)
    begin, end = rekeying.frame_span(action)
    low, high = (begin if first is None else max(first, begin)), (end if last is None else min(last, end))
    if high < low:
        raise SampError(f"'{action.name}' has no frames in this range; choose frames from {begin} to {end}.")
    motion = keyframes.read_motion(owner, action, begin, end, context.scene)
    aims = _over_time(context, target, range(begin, end + 1))
    stop = None if last is None or high == end else high - begin
    turned = look_at(motion, aims, low - begin, stop, ease)
    name = f"{action.name[:40]} look at {target.name}"[:58]
    new, slot = rekeying.rekey_copy(owner, action, motion, turned, begin, name)
    if action.library is None:
        action.use_fake_user = True
    keyframes.activate_action(owner, new, slot)
    return new


def point_of(context: bpy.types.Context, obj: bpy.types.Object) -> np.ndarray:
    """Return the point (3,) of an object that is looked at: a character's eyes, else the middle of its surface."""
    owner = obj if obj.type == "ARMATURE" else obj.find_armature()
    if owner is not None and (bone := _head(owner)) is not None:
        world = np.array(
            owner.evaluated_get(context.evaluated_depsgraph_get()).matrix_world, dtype=np.float64
        )
        middle = np.array((owner.pose.bones[bone].head + owner.pose.bones[bone].tail) / 2)
        return frames.to_network(world[:3, :3] @ middle + world[:3, 3])
    shown = obj.evaluated_get(context.evaluated_depsgraph_get())
    world = np.array(shown.matrix_world, dtype=np.float64)
    boxed = obj.type in ("MESH", "CURVE", "SURFACE", "FONT", "META")
    corners = np.array(shown.bound_box, dtype=np.float64) if boxed else np.zeros((1, 3))
    return frames.to_network(world[:3, :3] @ corners.mean(0) + world[:3, 3])


def _head(owner: bpy.types.Object) -> str | None:
    """Return the bone of an armature's head, or None."""
    if armature.is_smplx(owner):
        return armature.bone_name(owner, "head")
    return next((bone.name for bone in owner.data.bones if bone.name.lower().endswith("head")), None)


def _over_time(context: bpy.types.Context, target: bpy.types.Object, times: range) -> np.ndarray:
    """Return the point (T, 3) that is looked at in each frame; the frames of the scene are evaluated only where the
    target may move."""
    owner = target if target.type == "ARMATURE" else target.find_armature()
    if owner is None and seen.mover(target, True) is None:
        return np.tile(point_of(context, target), (len(times), 1))
    with seen.frame_kept(context.scene):
        found = []
        for frame in times:
            context.scene.frame_set(frame)
            found.append(point_of(context, target))
    return np.array(found)
