"""The pose of a control rig, written into a copy of the take."""

from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np

from ...errors import SampError
from ...motion import Motion
from ..actions import keyframes, rekeying
from ..actions.action_names import derived_name
from ..character import armature
from . import rig

SUFFIX = " controls"


def apply(context: bpy.types.Context, owner: bpy.types.Object, action: bpy.types.Action) -> bpy.types.Action:
    """Return a copy of a take in which the character has the poses of its control rig; it becomes the active Action.

    Raise SampError where there is no control rig.
    """
    shown = rig.find(owner)
    if shown is None:
        raise SampError(f"'{owner.name}' has no control rig; add one first.")
    keyframes.require_editable(owner)
    begin, end = rekeying.frame_span(action)
    motion = keyframes.read_motion(owner, action, begin, end, context.scene)
    poses = _poses(context, shown, range(begin, end + 1))
    root = np.concatenate([pose.root for pose in poses])
    new = replace(motion, root=root, rotations=np.concatenate([pose.rotations for pose in poses]))
    made, slot = rekeying.rekey_copy(owner, action, motion, new, begin, derived_name(action, SUFFIX))
    action.use_fake_user = action.use_fake_user or action.library is None
    keyframes.activate_action(owner, made, slot)
    return made


def _poses(context: bpy.types.Context, shown: bpy.types.Object, frames: range) -> list[Motion]:
    """Return the poses of an armature in some frames of the scene, one Motion each. The scene's frame is restored."""
    scene = context.scene
    now, sub = scene.frame_current, scene.frame_subframe
    try:
        found = []
        for frame in frames:
            scene.frame_set(frame)
            found.append(armature.posed(shown.evaluated_get(context.evaluated_depsgraph_get())))
    finally:
        scene.frame_set(now, subframe=sub)
    return found
