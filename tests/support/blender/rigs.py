"""Armatures as the two public SMPL-X add-ons make them, and takes to put on them."""

from __future__ import annotations

import math

import bpy
import numpy as np
from mathutils import Vector
from samp_blender.samp_addon import frames, rotation, skeleton
from samp_blender.samp_addon.blender.character.armature import bone_name
from samp_blender.samp_addon.motion import Motion


def reset() -> bpy.types.Scene:
    """An empty file at 30 frames a second."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.fps, scene.render.fps_base = 30, 1.0
    return scene


def make(family: str, joints: np.ndarray | None = None, name: str = "SMPLX") -> bpy.types.Object:
    """An armature like "mpi" (metres, tails up) or "meshcapade" (centimetres, object turned and scaled)."""
    joints = skeleton.default_rest_joints() if joints is None else joints
    joints = joints + np.array([0.003, -0.351, 0.012])  # SMPL-X's rest pelvis is not at the origin
    data = bpy.data.armatures.new(name)
    armature = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    tail = Vector((0, 0, 0.1)) if family == "mpi" else Vector((0, 10, 0))
    root = data.edit_bones.new("root")
    root.head, root.tail = (0, 0, 0), tail
    names = [n.replace("_smplhf", "") if family == "meshcapade" else n for n in skeleton.JOINTS]
    for j, bone_label in enumerate(names):
        bone = data.edit_bones.new(bone_label)
        bone.head = frames.to_blender(joints[j]) if family == "mpi" else joints[j] * 100
        bone.tail = bone.head + tail
        bone.parent = data.edit_bones[names[skeleton.PARENTS[j]]] if j else root
    bpy.ops.object.mode_set(mode="OBJECT")
    if family == "meshcapade":
        armature.scale, armature.rotation_euler = (0.01,) * 3, (math.pi / 2, 0, 0)
    for bone in armature.pose.bones:
        bone.rotation_mode = "QUATERNION"
    bpy.context.view_layer.update()
    return armature


def take(frames_count: int = 40, joints: int = 22, seed: int = 0, **changes: object) -> Motion:
    """A wild but smooth take: every joint turns, the root travels, quaternion signs flip at random."""
    rng = np.random.default_rng(seed)
    vectors = rng.normal(size=(1, joints, 3)) * 0.4 + np.cumsum(
        rng.normal(size=(frames_count, joints, 3)) * 0.05, 0
    )
    signs = rng.choice([-1.0, 1.0], size=(frames_count, joints, 1))
    root = np.array([1.5, 0.9, -2.0]) + np.cumsum(rng.normal(size=(frames_count, 3)) * 0.02, 0)
    return Motion(root, rotation.from_axis_angle(vectors) * signs, **changes)


def world_joints(armature: bpy.types.Object, frame: float) -> np.ndarray:
    """Heads (22, 3) of the posed body bones in the network frame, as Blender shows them at a frame."""
    bpy.context.scene.frame_set(int(frame), subframe=frame % 1)
    shown = armature.evaluated_get(bpy.context.evaluated_depsgraph_get())
    heads = [
        shown.matrix_world @ shown.pose.bones[bone_name(armature, joint)].head
        for joint in skeleton.BODY_JOINTS
    ]
    return frames.to_network(np.array(heads))
