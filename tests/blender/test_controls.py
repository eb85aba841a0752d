"""The control rig: it shows a take as it is, moves a hand that is pulled, and leaves nothing behind."""

from __future__ import annotations

import bpy
import fakes
import fingerprint
import numpy as np
import pytest
import rooms
from samp_blender.samp_addon import rotation
from samp_blender.samp_addon.blender.actions import keyframes
from samp_blender.samp_addon.blender.character import armature, characters
from samp_blender.samp_addon.blender.controls import applying, rig
from samp_blender.samp_addon.methods.samp import networks
from samp_blender.samp_addon.motion import Motion

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def owner():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.samp.create_character(location=(1.0, -2.0, 0.3), yaw=0.7)
    made = bpy.data.objects["Human"]
    wild(made, 0)
    return made


def wild(owner, seed):
    """A take in which every joint turns by up to half a radian, and knees and elbows bend far."""
    rng = np.random.default_rng(seed)
    waves = np.sin(np.linspace(0, 6, 30)[:, None, None] + rng.uniform(0, 6, (1, 55, 3)))
    turns = 0.5 * waves * rng.uniform(0, 1, (1, 55, 3))
    for joint, axis, most in (("left_knee", 0, 2.0), ("right_knee", 0, 2.2), ("left_elbow", 1, -2.0)):
        turns[:, armature.skeleton.INDEX[joint]] = 0
        turns[:, armature.skeleton.INDEX[joint], axis] = np.linspace(0.02, most, 30)
    root = np.array([1.0, 1.2, 2.0]) + 0.02 * np.arange(30)[:, None]
    motion = Motion(root, rotation.from_axis_angle(turns))
    return keyframes.write_motion(owner, motion, f"wild {seed}", scene=bpy.context.scene)


def apart(owner):
    """The largest distance and angle between bones of the character and of its control rig: metres, degrees."""
    shown, worst = rig.find(owner), np.zeros(2)
    for frame in range(1, 31, 3):
        bpy.context.scene.frame_set(frame)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        one, two = (obj.evaluated_get(depsgraph) for obj in (owner, shown))
        for bone in one.pose.bones:
            a, b = (np.array(obj.matrix_world @ obj.pose.bones[bone.name].matrix) for obj in (one, two))
            turned = np.linalg.norm(a[:3, :3] - b[:3, :3]) / np.sqrt(2)  # radians, exact to the first order
            worst = np.maximum(worst, [np.linalg.norm(a[:3, 3] - b[:3, 3]), np.degrees(turned)])
    return worst


def skin(owner):
    depsgraph = bpy.context.evaluated_depsgraph_get()
    mesh = next(obj for obj in owner.children if obj.type == "MESH").evaluated_get(depsgraph)
    return np.array([mesh.matrix_world @ vertex.co for vertex in mesh.data.vertices])


def test_every_take_is_shown_as_it_is(owner):
    bpy.context.scene.frame_set(20)
    before = skin(owner)
    assert bpy.ops.samp.add_control_rig() == {"FINISHED"}
    bpy.context.scene.frame_set(20)
    assert np.abs(skin(owner) - before).max() < 1e-3
    distance, angle = apart(owner)
    assert distance < 1e-3 and angle < 0.1
    wild(owner, 1)  # another take, without another press
    distance, angle = apart(owner)
    assert distance < 1e-3 and angle < 0.1


def test_a_hand_follows_its_control_and_the_take_stays(owner):
    rig.add(bpy.context, owner)
    bpy.context.scene.frame_set(5)
    hand = bpy.data.objects["Human left hand"]
    shown, bone = rig.find(owner), armature.bone_name(owner, "left_wrist")
    shoulder = armature.bone_name(owner, "left_shoulder")
    before, trunk = (owner.matrix_world @ owner.pose.bones[name].head for name in (bone, shoulder))
    world = hand.matrix_world.copy()
    world.translation += 0.06 * (trunk - before).normalized()
    hand.matrix_world = world
    bpy.context.view_layer.update()
    moved = shown.evaluated_get(bpy.context.evaluated_depsgraph_get())
    after = np.array(moved.matrix_world @ moved.pose.bones[bone].head)
    assert np.linalg.norm(after - np.array(world.translation)) < 2e-3
    np.testing.assert_allclose(owner.matrix_world @ owner.pose.bones[bone].head, before, atol=1e-6)


def test_removing_restores_everything_and_can_keep_what_was_done(owner):
    before = fingerprint.taken()
    rig.add(bpy.context, owner)
    hand = bpy.data.objects["Human right hand"]
    hand.keyframe_insert("location", frame=1)
    assert bpy.ops.samp.remove_control_rig() == {"FINISHED"}
    assert fingerprint.differences(before, fingerprint.taken(), additions=False) == []

    rig.add(bpy.context, owner)
    foot = bpy.data.objects["Human right foot"]
    foot.location.y += 0.05
    bpy.context.view_layer.update()
    take = owner.animation_data.action
    bpy.context.scene.frame_set(12)
    wanted = armature.posed(rig.find(owner).evaluated_get(bpy.context.evaluated_depsgraph_get()))
    assert bpy.ops.samp.remove_control_rig(apply=True) == {"FINISHED"}
    made = owner.animation_data.action
    assert made != take and made.name == take.name + applying.SUFFIX
    bpy.context.scene.frame_set(12)
    now = armature.posed(owner).forward_kinematics()[0]
    np.testing.assert_allclose(now, wanted.forward_kinematics()[0], atol=1e-3)
    compare = keyframes.read_motion(owner, take).forward_kinematics()[0][11]
    assert np.abs(compare - now[0]).max() > 0.02


def test_a_control_rig_is_no_character_and_no_furniture(owner, monkeypatch):
    monkeypatch.setattr(networks, "trained", lambda: fakes.NETWORKS)
    rig.add(bpy.context, owner)
    assert characters.people(bpy.context) == [owner] and armature.find(bpy.context) == owner
    mesh = next(obj for obj in owner.children if obj.type == "MESH")
    assert mesh.find_armature() == owner
    bpy.context.view_layer.objects.active = bpy.data.objects["Human left hand"]
    assert rig.character(bpy.context) == owner
    rooms.to_blender(rooms.random_room(1, rooms.sofa), bpy.context.scene)
    bpy.context.view_layer.objects.active = owner
    assert bpy.ops.samp.sit_here(target="Sofa", seed=3, hold=0.5) == {"FINISHED"}
    assert apart(owner)[0] < 1e-3


@pytest.mark.parametrize(
    ("press", "message"),
    [
        (lambda: bpy.ops.samp.remove_control_rig(), "has no control rig"),
        (lambda: bpy.ops.samp.remove_control_rig(apply=True), "has no control rig"),
        (lambda: [bpy.ops.samp.add_control_rig() for _ in range(2)], "has a control rig already"),
    ],
)
def test_why_not(owner, press, message):
    with pytest.raises(RuntimeError, match=message):
        press()
