"""Edited copies of a take: fewer keys, other speeds, cycles. The take itself stays as it was."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
import recordings
from samp_blender.samp_addon.blender import compat
from samp_blender.samp_addon.blender.actions import keyframes, notes, reduce_keys
from samp_blender.samp_addon.blender.character import character
from samp_blender.samp_addon.edits import key_reduction
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.motion import Goal

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def owner():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.context.scene.render.fps = 30
    return character.create_character(bpy.context)


@pytest.fixture
def take(owner):
    made = keyframes.write_motion(owner, recordings.walk(120), "walk", frame_start=11)
    notes.write_goal(made, Goal(np.array([0.0, 0.9, 4.0]), np.array([0.0, 0.0, 1.0]), "walk"))
    return made


def content(action, owner):
    return {(c.data_path, c.array_index): [tuple(k.co) for k in c.keyframe_points]
            for c in compat.curves(action, owner)}  # fmt: skip


def test_reduced_keys_stay_within_the_bound_and_can_be_read_back(owner, take):
    before, motion = content(take, owner), keyframes.read_motion(owner, take)
    assert bpy.ops.samp.reduce_keys(action_name="walk", angle=0.2) == {"FINISHED"}
    made = owner.animation_data.action
    assert made.name == "walk reduced" and notes.is_take(made) and made.use_fake_user
    assert content(take, owner) == before
    counts = [len(keys) for keys in content(made, owner).values()]
    assert sum(counts) < sum(len(keys) for keys in before.values()) / 3
    again = keyframes.read_motion(owner, made)
    assert len(again) == 120 and np.linalg.norm(again.root - motion.root, axis=-1).max() < 1.05e-3
    same = np.sign((motion.rotations * again.rotations).sum(-1, keepdims=True))
    pairs = ((values[:, :22].reshape(-1, 4)) for values in (again.rotations, same * motion.rotations))
    turned = key_reduction.angle_error(*pairs)
    assert np.degrees(turned.max()) < 0.205


@pytest.mark.parametrize("mode", ["XYZ", "AXIS_ANGLE"])
def test_other_rotation_modes_are_reduced_too(owner, mode):
    for bone in owner.pose.bones:
        bone.rotation_mode = mode
    take = keyframes.write_motion(owner, recordings.walk(60), "walk")
    motion = keyframes.read_motion(owner, take)
    made = reduce_keys.run(owner, take, 0.001, 0.5)
    assert made.after < made.before / 2
    again = keyframes.read_motion(owner, made.action)
    ends = [m.forward_kinematics()[0][:, :22] for m in (motion, again)]
    assert np.linalg.norm(ends[1] - ends[0], axis=-1).max() < 0.02


def test_nothing_is_left_to_reduce(owner, take):
    reduced = reduce_keys.run(owner, take)
    with pytest.raises(SampError, match="nothing to reduce"):
        reduce_keys.run(owner, reduced.action)


def test_retimed(owner, take):
    before = content(take, owner)
    assert bpy.ops.samp.retime_take(action_name="walk", walk=0.5) == {"FINISHED"}
    made = owner.animation_data.action
    assert made.name == "walk retimed" and notes.read_goal(made).action == "walk"
    assert made.frame_range[0] == 11 and made.frame_range[1] == pytest.approx(11 + 238, abs=2)
    assert content(take, owner) == before


@pytest.mark.parametrize("in_place", [False, True])
def test_loops_go_on_for_ever(owner, take, in_place):
    assert bpy.ops.samp.loop_take(action_name="walk", in_place=in_place) == {"FINISHED"}
    made = owner.animation_data.action
    assert made.name == ("walk in place" if in_place else "walk loop")
    length = int(made.curve_frame_range[1] - made.curve_frame_range[0])
    assert length % 24 == 0
    many = keyframes.read_motion(owner, made, 11, 11 + 3 * length)
    gone = np.linalg.norm((many.root[-1] - many.root[0])[[0, 2]])
    assert gone == pytest.approx(0.0 if in_place else 3 * 1.1 * length / 30, abs=0.08)
    np.testing.assert_allclose(many.rotations[length], many.rotations[0], atol=1e-5)


def test_edits_are_offered_in_the_list_and_refuse_what_is_no_take(owner, take):
    from samp_blender.samp_addon.ui import takes

    assert [name for name, _ in takes.EDITS] == [
        "retime_take",
        "loop_take",
        "reduce_keys",
        "blend_take",
        "redo_from_here",
        "follow_goal",
    ]
    for name, _ in (*takes.EDITS, *takes.PLACED):
        with pytest.raises(RuntimeError, match="There is no take 'nothing'"):
            getattr(bpy.ops.samp, name)(action_name="nothing")
