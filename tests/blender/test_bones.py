"""The bones of the default human: from joint to joint, inside the body, and with the same motion as before."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.blender.actions import keyframes
from samp_blender.samp_addon.blender.character import armature, character
from samp_blender.tests.support.blender import rigs

LIMBS = ("hip", "knee", "ankle", "shoulder", "elbow", "wrist", "collar")
INSIDE = 0.8
"""Least share of the middles of bones that are inside the body: eyes, jaw and toes are near the skin."""


@pytest.fixture
def owner():
    rigs.reset()
    return character.create_character(bpy.context, location=(1.0, 2.0, 0.0), yaw=0.7)


def test_bones_end_at_the_next_joint(owner):
    bones = owner.data.bones
    for side in ("left", "right"):
        for joint, after in (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist")):
            gap = bones[f"{side}_{joint}"].tail_local - bones[f"{side}_{after}"].head_local
            assert gap.length < 1e-5
    assert (bones["spine1"].tail_local - bones["spine2"].head_local).length < 1e-5
    assert all(bone.length > 0.005 for bone in bones)


def test_bones_run_inside_the_body(owner):
    mesh = next(child for child in owner.children if child.type == "MESH")
    for bone in owner.pose.bones:
        bone.rotation_quaternion = (1, 0, 0, 0)
    bpy.context.view_layer.update()
    tree = BVHTree.FromObject(mesh, bpy.context.evaluated_depsgraph_get())
    inside = {}
    for joint in skeleton.JOINTS:
        bone = owner.data.bones[joint]
        inside[joint] = _inside(tree, (bone.head_local + bone.tail_local) / 2)
    assert all(inside[f"{side}_{limb}"] for side in ("left", "right") for limb in LIMBS)
    assert np.mean(list(inside.values())) > INSIDE


def _inside(tree: BVHTree, point: Vector) -> bool:
    """Whether an odd number of faces is above a point."""
    count, place = 0, point.copy()
    while True:
        hit = tree.ray_cast(place, Vector((0.013, 0.007, 1.0)))[0]
        if hit is None:
            return count % 2 == 1
        count, place = count + 1, hit + Vector((0.0, 0.0, 1e-4))


@pytest.mark.parametrize("joints", [22, 55])
def test_takes_show_the_same_joints(owner, joints):
    take = rigs.take(20, joints)
    keyframes.write_motion(owner, take)
    positions, _ = take.forward_kinematics()
    for frame in (0, 10, 19):
        assert np.abs(rigs.world_joints(owner, 1 + frame) - positions[frame][:22]).max() < 1e-4
    again = keyframes.read_motion(owner)
    assert np.abs(again.root - take.root).max() < 1e-4


def test_standing_pose_has_arms_down_and_mirrored(owner):
    joints = armature.posed(owner).forward_kinematics()[0][0]
    at = {name: joints[skeleton.INDEX[name]] for name in skeleton.JOINTS}
    for side in ("left", "right"):
        assert at[f"{side}_wrist"][1] < at[f"{side}_shoulder"][1] - 0.35
    pelvis = at["pelvis"]
    facing = np.array([np.sin(0.7), 0.0, np.cos(0.7)])
    across = np.cross([0.0, 1.0, 0.0], facing)
    for joint in ("elbow", "wrist", "middle3"):
        left, right = at[f"left_{joint}"] - pelvis, at[f"right_{joint}"] - pelvis
        assert abs(left @ across + right @ across) < 0.02 and abs(left[1] - right[1]) < 0.02


def test_pose_is_read_back(owner):
    """The rotations of a pose are SMPL-X's, whatever the axes of the bones."""
    take = rigs.take(3, 55)
    keyframes.write_motion(owner, take)
    bpy.context.scene.frame_set(2)
    pose = armature.posed(owner)
    same = np.abs(np.sum(pose.rotations[0] * rotation.normalise(take.rotations[1]), axis=-1))
    assert same.min() > 1 - 1e-6 and np.abs(pose.root[0] - take.root[1]).max() < 1e-4
