"""Motions as Actions: Blender evaluates what was written, and no data of the artist are lost."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.blender import compat
from samp_blender.samp_addon.blender.actions import keyframes
from samp_blender.samp_addon.blender.character import armature, character
from samp_blender.samp_addon.body import human, proportions
from samp_blender.samp_addon.errors import SampError
from samp_blender.tests.blender.test_armature import FAMILIES, place
from samp_blender.tests.support.blender import rigs

HUNDREDTH_OF_A_MILLIMETRE = 1e-5


@pytest.fixture(autouse=True)
def scene():
    return rigs.reset()


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("how", ["still", "moved", "turned", "scaled", "parented"])
def test_blender_evaluates_the_motion(family, how):
    owner = rigs.make(family)
    place(owner, how)
    take = rigs.take(contacts=np.random.default_rng(1).random((40, 5)))
    action = keyframes.write_motion(owner, take, "Take", frame_start=11)
    expected = proportions.adapt(take, armature.calibrate(owner).rest_joints)
    positions, _ = expected.forward_kinematics()
    for t in (0, 7, 23, 39):
        assert np.abs(rigs.world_joints(owner, 11 + t) - positions[t]).max() < HUNDREDTH_OF_A_MILLIMETRE
    assert tuple(action.frame_range) == (11, 50)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("joints", [22, 55])
def test_round_trip(family, joints):
    owner = rigs.make(family)
    place(owner, "turned")
    rng = np.random.default_rng(2)
    take = rigs.take(
        30, joints, contacts=rng.random((30, 5)), actions=rng.random((30, 5)), interaction_start=12
    )
    action = keyframes.write_motion(owner, take, frame_start=-3)
    again = keyframes.read_motion(owner, action)
    assert len(again) == 30 and again.fps == 30 and again.interaction_start == 12
    assert np.abs(again.root - take.root).max() < HUNDREDTH_OF_A_MILLIMETRE
    dots = np.abs(np.sum(again.rotations[:, :joints] * take.rotations, axis=-1))
    assert dots.min() > 1 - 1e-9
    assert np.allclose(again.contacts, take.contacts) and np.allclose(again.actions, take.actions)
    part = keyframes.read_motion(owner, action, 5, 9)
    assert len(part) == 5 and part.interaction_start == 4
    assert np.abs(part.root - again.root[8:13]).max() < 1e-12


@pytest.mark.parametrize("mode", ["XYZ", "ZXY", "YZX", "AXIS_ANGLE", "QUATERNION"])
def test_rotation_modes_of_the_artist_are_kept(mode):
    owner = rigs.make("mpi")
    for bone in owner.pose.bones:
        bone.rotation_mode = mode
    take = rigs.take()
    keyframes.write_motion(owner, take)
    positions, _ = take.forward_kinematics()
    for t in (0, 20, 39):
        assert np.abs(rigs.world_joints(owner, 1 + t) - positions[t]).max() < HUNDREDTH_OF_A_MILLIMETRE
    assert {bone.rotation_mode for bone in owner.pose.bones} == {mode}
    assert np.abs(keyframes.read_motion(owner).root - take.root).max() < HUNDREDTH_OF_A_MILLIMETRE


def test_quaternions_are_continuous():
    owner = rigs.make("mpi")
    action = keyframes.write_motion(owner, rigs.take(60))
    curves = {(c.data_path, c.array_index): c for c in compat.curves(action, owner)}
    for joint in skeleton.BODY_JOINTS:
        path = f'pose.bones["{joint}"].rotation_quaternion'
        values = np.array([[key.co.y for key in curves[path, k].keyframe_points] for k in range(4)])
        assert np.sum(values[:, 1:] * values[:, :-1], axis=0).min() > 0
        assert np.abs(np.linalg.norm(values, axis=0) - 1).max() < 1e-6


@pytest.mark.parametrize(
    ("fps", "base", "frames"), [(24, 1.0, 33), (60, 1.0, 81), (30, 1.001, 41), (25, 1.0, 34)]
)
def test_resampled_to_the_scene(scene, fps, base, frames):
    scene.render.fps, scene.render.fps_base = fps, base
    owner = rigs.make("mpi")
    take = rigs.take(41, interaction_start=30)
    action = keyframes.write_motion(owner, take)
    assert action.frame_range[1] == frames
    again = keyframes.read_motion(owner, action)
    assert again.fps == pytest.approx(fps / base)
    assert abs(again.interaction_start / again.fps - 1.0) < 0.6 / again.fps
    # The pelvis after one second is the same.
    assert np.abs(rigs.world_joints(owner, 1 + fps)[0] - take.root[30]).max() < 1e-3


def test_the_artists_action_is_kept_and_untouched():
    owner = rigs.make("mpi")
    owner.pose.bones["left_knee"].keyframe_insert("rotation_quaternion", frame=1)
    owner.keyframe_insert("location", frame=1)
    own = owner.animation_data.action
    own.use_fake_user = False
    before = [
        (c.data_path, c.array_index, [tuple(k.co) for k in c.keyframe_points])
        for c in compat.curves(own, owner)
    ]
    first = keyframes.write_motion(owner, rigs.take(), "Take")
    second = keyframes.write_motion(owner, rigs.take(seed=5), "Take")
    assert own.users >= 1 and first.users >= 1 and first != second and owner.animation_data.action == second
    keyframes.activate_action(owner, own)
    after = [
        (c.data_path, c.array_index, [tuple(k.co) for k in c.keyframe_points])
        for c in compat.curves(own, owner)
    ]
    assert before == after
    keyframes.activate_action(owner, first)
    assert np.abs(rigs.world_joints(owner, 1)[0] - rigs.take().root[0]).max() < HUNDREDTH_OF_A_MILLIMETRE


def test_activate_false_keeps_the_active_action():
    owner = rigs.make("mpi")
    action = keyframes.write_motion(owner, rigs.take(), activate=False)
    assert owner.animation_data is None or owner.animation_data.action is None
    assert action.use_fake_user and len(keyframes.read_motion(owner, action)) == 40


def test_a_posed_root_and_moved_bones_do_not_interfere():
    owner = rigs.make("mpi")
    owner.pose.bones["root"].location = (1, 2, 3)
    owner.pose.bones["root"].rotation_quaternion = rotation.from_axis_angle(np.array([0.3, 0.2, 0.1]))
    owner.pose.bones["left_knee"].location = (0.1, 0, 0)
    owner.pose.bones["spine1"].scale = (1.5, 1.5, 1.5)
    take = rigs.take()
    keyframes.write_motion(owner, take)
    positions, _ = take.forward_kinematics()
    assert np.abs(rigs.world_joints(owner, 20) - positions[19]).max() < HUNDREDTH_OF_A_MILLIMETRE


def test_reads_an_animated_root_bone():
    owner = rigs.make("mpi")
    keyframes.write_motion(owner, rigs.take())
    root = owner.pose.bones["root"]
    root.location, root.rotation_quaternion = (1, 2, 3), rotation.from_axis_angle(np.array([0.3, 0.2, 0.1]))
    root.keyframe_insert("location", frame=1)
    root.keyframe_insert("rotation_quaternion", frame=1)
    positions, _ = keyframes.read_motion(owner).forward_kinematics()
    assert np.abs(positions[9, :22] - rigs.world_joints(owner, 10)).max() < HUNDREDTH_OF_A_MILLIMETRE


def spoil(name: str, value: float):
    take = rigs.take()
    getattr(take, name)[3, ..., 0] = value
    return take


@pytest.mark.parametrize("take", [spoil("root", np.nan), spoil("rotations", np.inf), rigs.take(0)])
def test_invalid_motions_raise(take):
    owner = rigs.make("mpi")
    with pytest.raises(SampError, match="generate it again"):
        keyframes.write_motion(owner, take)
    assert not bpy.data.actions and owner.animation_data is None


def test_reading_without_an_action():
    with pytest.raises(SampError, match="has no Action"):
        keyframes.read_motion(rigs.make("mpi"))


def test_tweak_mode_raises():
    owner = rigs.make("mpi")
    first = keyframes.write_motion(owner, rigs.take())
    data = owner.animation_data
    track = data.nla_tracks.new()
    track.strips.new("strip", 1, first)
    data.action = None
    bpy.context.view_layer.objects.active = owner
    track.select = track.strips[0].select = True
    data.use_tweak_mode = True
    if not data.use_tweak_mode:
        pytest.skip("this Blender enters tweak mode from its NLA editor only")
    with pytest.raises(SampError, match="tweak mode"):
        keyframes.write_motion(owner, rigs.take())


@pytest.mark.parametrize("shape", ["tall", "short"])
def test_other_legs_keep_feet_on_the_floor_and_the_pelvis_on_the_seat(shape):
    body, other = human.load(), human.load().shaped({shape: 1.0})
    still = np.tile([1.0, 0, 0, 0], (2, 22, 1))
    # Sitting: thighs horizontal, shins vertical.
    for side in ("left", "right"):
        still[1, skeleton.INDEX[f"{side}_hip"]] = rotation.from_axis_angle(np.radians([-90.0, 0, 0]))
        still[1, skeleton.INDEX[f"{side}_knee"]] = rotation.from_axis_angle(np.radians([90.0, 0, 0]))
    root = np.array([[0, -body.floor, 0], [0, 0.53, 0]])
    contacts = np.array([[0.0, 0, 0, 1, 1], [1, 0, 0, 1, 1]])
    take = proportions.Motion(root, still, contacts=contacts)
    owner = character.create_character(bpy.context, {shape: 1.0})
    keyframes.write_motion(owner, take)
    shown = keyframes.read_motion(owner)
    soles = human.skin(other, shown)[0, :, 1].min()
    assert abs(soles) < 0.005
    assert abs(shown.root[1, 1] - 0.53) < 0.02
