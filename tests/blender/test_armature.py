"""SMPL-X armatures from elsewhere: found, calibrated at any place, or rejected with a reason."""

from __future__ import annotations

import math

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from samp_blender.samp_addon import skeleton
from samp_blender.samp_addon.blender.character import armature, character
from samp_blender.samp_addon.body import human
from samp_blender.samp_addon.errors import SampError
from samp_blender.tests.support.blender import rigs

FAMILIES = ("mpi", "meshcapade")


@pytest.fixture(autouse=True)
def _empty_file():
    rigs.reset()


def place(owner: bpy.types.Object, how: str) -> float:
    """Move, rotate, scale or parent an armature; return its size relative to the original."""
    turn = Matrix.Rotation(0.7, 4, "Z") @ Matrix.Rotation(0.3, 4, "X")
    if how == "moved":
        owner.matrix_world = Matrix.Translation((3, -2, 0.4)) @ owner.matrix_world
    elif how == "turned":
        owner.matrix_world = turn @ owner.matrix_world
    elif how == "scaled":
        owner.matrix_world = Matrix.Scale(1.2, 4) @ owner.matrix_world
        return 1.2
    elif how == "parented":
        parent = bpy.data.objects.new("Parent", None)
        bpy.context.scene.collection.objects.link(parent)
        parent.matrix_world = Matrix.Translation((1, 2, 3)) @ turn @ Matrix.Scale(0.8, 4)
        owner.parent = parent
        return 0.8
    return 1.0


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("how", ["still", "moved", "turned", "scaled", "parented"])
def test_measures_rest_joints(family, how):
    owner = rigs.make(family)
    size = place(owner, how)
    found = armature.calibrate(owner)
    assert np.abs(found.rest_joints - skeleton.default_rest_joints() * size).max() < 1e-5
    assert np.allclose(found.axes, np.round(found.axes))


@pytest.mark.parametrize("shape", ["female", "tall", "heavy", "elder"])
@pytest.mark.parametrize("family", FAMILIES)
def test_other_proportions_do_not_tilt_the_axes(family, shape):
    joints = human.load().shaped({shape: 1.0}).joints
    found = armature.calibrate(rigs.make(family, joints))
    assert np.allclose(found.axes, np.round(found.axes))
    assert np.abs(found.rest_joints - joints).max() < 1e-5


def test_rotation_applied_to_the_rest_pose():
    owner = rigs.make("mpi")
    owner.data.transform(Matrix.Rotation(math.radians(30), 4, "Z"))
    found = armature.calibrate(owner)
    assert np.abs(found.rest_joints - skeleton.default_rest_joints()).max() < 0.01


@pytest.mark.parametrize(("facing", "yaw"), [(0.0, 0.0), (90.0, math.pi / 2), (-120.0, -math.radians(120))])
def test_standing_place(facing, yaw):
    owner = character.create_character(bpy.context, {}, (1.0, 2.0, 0.0), math.radians(facing))
    position, found = armature.standing_place(owner)
    assert found == pytest.approx(yaw, abs=1e-5)
    assert position == pytest.approx((1.0, -human.load().floor, -2.0), abs=1e-4)


def test_another_rig_names_the_missing_bones():
    owner = rigs.make("mpi", name="Rig")
    bpy.ops.object.mode_set(mode="EDIT")
    owner.data.edit_bones["left_hip"].name = "thigh.L"
    owner.data.edit_bones["spine3"].name = "chest"
    bpy.ops.object.mode_set(mode="OBJECT")
    with pytest.raises(
        SampError, match=r"'Rig' is not an SMPL-X armature: it lacks the bones left_hip, spine3;"
    ):
        armature.calibrate(owner)


def break_scale(owner: bpy.types.Object) -> None:
    owner.scale = (1.0, 1.0, 1.3)


def mirror(owner: bpy.types.Object) -> None:
    owner.scale = (-1.0, 1.0, 1.0)


def vanish(owner: bpy.types.Object) -> None:
    owner.scale = (0.0, 0.0, 0.0)


def lower_arms(owner: bpy.types.Object) -> None:
    turn = Matrix.Rotation(math.radians(50), 3, "Y")
    bpy.ops.object.mode_set(mode="EDIT")
    bones = owner.data.edit_bones
    pivot = bones["left_shoulder"].head.copy()
    for bone in (bones["left_elbow"], bones["left_wrist"]):
        bone.head, bone.tail = pivot + turn @ (bone.head - pivot), pivot + turn @ (bone.tail - pivot)
    bpy.ops.object.mode_set(mode="OBJECT")


def hang_elsewhere(owner: bpy.types.Object) -> None:
    bpy.ops.object.mode_set(mode="EDIT")
    owner.data.edit_bones["left_knee"].parent = owner.data.edit_bones["root"]
    bpy.ops.object.mode_set(mode="OBJECT")


def ignore_parents(owner: bpy.types.Object) -> None:
    owner.data.bones["left_knee"].use_inherit_rotation = False


@pytest.mark.parametrize(
    ("harm", "reason"),
    [
        (break_scale, "differs by axis"),
        (mirror, "mirrors"),
        (vanish, "scale of zero"),
        (lower_arms, "T-pose"),
        (hang_elsewhere, "'left_knee' of '.*' is not a child of 'left_hip'"),
        (ignore_parents, "does not inherit rotation"),
    ],
)
def test_invalid_armatures_raise(harm, reason):
    owner = rigs.make("mpi")
    harm(owner)
    with pytest.raises(SampError, match=reason):
        armature.calibrate(owner)


def test_find():
    context = bpy.context
    with pytest.raises(SampError, match="create a character first"):
        armature.find(context)
    owner = character.create_character(context, name="Anna")
    context.view_layer.objects.active = None
    assert armature.find(context) == owner  # the only one
    other = character.create_character(context, name="Bert")
    context.view_layer.objects.active = owner.children[0]
    assert armature.find(context) == owner  # the one that deforms the active mesh
    context.view_layer.objects.active = None
    with pytest.raises(SampError, match="'Anna', 'Bert'"):
        armature.find(context)
    assert armature.find(context, "Bert") == other
    with pytest.raises(SampError, match="no object 'Carl'"):
        armature.find(context, "Carl")
