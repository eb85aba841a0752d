"""Reads any rig in its rest pose, with the meshes that it deforms."""

from __future__ import annotations

import bpy
import numpy as np

from ...errors import SampError
from ...rigs.rig import Rig
from ..character.armature import orthonormal, turn_and_scale

MAX_VERTICES = 20_000
"""Skin vertices that are read; larger meshes are subsampled."""


def read(context: bpy.types.Context, armature: bpy.types.Object) -> Rig:
    """Return the rig of an armature, with its object where it is now.

    Raise SampError for an armature without bones, and for a scale that differs by axis.
    """
    context.view_layer.update()  # matrix_world is stale after a script moved the object
    bones = list(armature.data.bones)
    if not bones:
        raise SampError(f"'{armature.name}' has no bones; choose the armature of a character.")
    index = {bone.name: k for k, bone in enumerate(bones)}
    world = np.array(armature.matrix_world, dtype=np.float64)
    turn, scale = turn_and_scale(armature.name, world)
    pose = armature.pose.bones
    return Rig(
        name=armature.name,
        names=tuple(index),
        parents=np.array([index[bone.parent.name] if bone.parent else -1 for bone in bones]),
        heads=np.array([bone.head_local for bone in bones], dtype=np.float64),
        tails=np.array([bone.tail_local for bone in bones], dtype=np.float64),
        bases=orthonormal(
            np.array([np.array(bone.matrix_local.to_3x3()) for bone in bones], dtype=np.float64)
        ),
        constrained=np.array([any(not c.mute for c in pose[bone.name].constraints) for bone in bones]),
        inherits=np.array([bone.use_inherit_rotation for bone in bones]),
        world=world,
        turn=turn,
        scale=scale,
        skin=_skin(context, armature, world),
    )


def _skin(context: bpy.types.Context, armature: bpy.types.Object, world: np.ndarray) -> np.ndarray:
    """Return rest vertices (N, 3) of the meshes that an armature deforms, in its axes and units."""
    inverse, found = np.linalg.inv(world), [np.zeros((0, 3))]
    for obj in context.scene.objects:
        if obj.type != "MESH" or obj.parent_type == "BONE" or obj.find_armature() != armature:
            continue
        points = np.empty(len(obj.data.vertices) * 3, dtype=np.float32)
        obj.data.vertices.foreach_get("co", points)
        to_armature = inverse @ np.array(obj.matrix_world, dtype=np.float64)
        found.append(points.reshape(-1, 3) @ to_armature[:3, :3].T + to_armature[:3, 3])
    skin = np.concatenate(found)
    return skin[:: max(1, -(-len(skin) // MAX_VERTICES))]
