"""Redo From Here and Follow: a new end after frames that stay bit for bit."""

from __future__ import annotations

import bpy
import fakes
import numpy as np
import pytest
import sofa_room
from samp_blender.samp_addon.blender import compat
from samp_blender.samp_addon.blender.actions import keyframes, notes
from samp_blender.samp_addon.blender.edits import following, origin, redo, watching
from samp_blender.samp_addon.methods.samp import networks

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture(autouse=True)
def _fake_networks(monkeypatch):
    monkeypatch.setattr(networks, "trained", lambda: fakes.NETWORKS)


@pytest.fixture
def owner():
    return sofa_room.build(fps=24)


def keys(action, owner, last=None):
    """All keys of an Action, or those up to a frame."""
    return {
        (curve.data_path, curve.array_index): [
            tuple(key.co) for key in curve.keyframe_points if last is None or key.co.x <= last
        ]
        for curve in compat.curves(action, owner)
    }


def sat(owner, **options):
    assert bpy.ops.samp.sit_here(target="Sofa", seed=3, hold=1.0, **options) == {"FINISHED"}
    return owner.animation_data.action


def shown(owner, action):
    return keyframes.read_motion(owner, action)


@pytest.mark.parametrize("frame", [1, 12, 40])
def test_frames_before_stay_bit_for_bit_and_the_end_is_new(owner, frame):
    take = sat(owner)
    before = keys(take, owner)
    bpy.context.scene.frame_set(frame)
    assert bpy.ops.samp.redo_from_here() == {"FINISHED"}
    made = owner.animation_data.action
    assert made.name == take.name + " redo" and notes.is_take(made)
    assert keys(take, owner) == before
    old, new = keys(take, owner, frame), keys(made, owner, frame)
    assert all(new[path] == old[path] for path in old)
    motion, whole = shown(owner, take), shown(owner, made)
    end = min(len(motion), len(whole))
    assert np.abs(whole.root[frame + 2 : end] - motion.root[frame + 2 : end]).max() > 1e-4
    assert np.linalg.norm(np.diff(whole.root, axis=0), axis=-1).max() < 0.2  # metres in a frame
    goal = notes.read_goal(made)
    assert np.linalg.norm(whole.root[-1] - goal.position) < 0.1
    assert whole.contacts is not None and len(whole.contacts) == len(whole)
    assert origin.read(made).job.seed == 4 and origin.read(made).ends == (round(made.frame_range[1]),)
    again = redo.run(bpy.context, owner, made, frame)
    assert again.action.name.startswith(take.name + " redo")


def test_the_operator_does_what_the_function_does(owner):
    take = sat(owner)
    bpy.ops.samp.redo_from_here(action_name=take.name, use_frame=True, frame=20, seed=9)
    made = owner.animation_data.action
    assert keys(redo.run(bpy.context, owner, take, 20, 9).action, owner) == keys(made, owner)


def test_a_moved_sofa_is_followed(owner):
    take = sat(owner)
    with pytest.raises(RuntimeError, match="was moved"):
        bpy.ops.samp.follow_goal(action_name=take.name)
    sofa = bpy.data.objects["Sofa"]
    sofa.location.x += 0.4
    frame, seed = following.first_frame(bpy.context, owner, take)
    assert seed == 3 and frame >= 1
    assert bpy.ops.samp.follow_goal(action_name=take.name) == {"FINISHED"}
    made = owner.animation_data.action
    old, new = keys(take, owner, frame), keys(made, owner, frame)
    assert made != take and all(new[path] == old[path] for path in old)
    moved = notes.read_goal(made).position - notes.read_goal(take).position
    np.testing.assert_allclose(moved, [0.4, 0, 0], atol=0.1)
    assert np.linalg.norm(shown(owner, made).root[-1] - notes.read_goal(made).position) < 0.1
    assert following.changes(bpy.context, origin.read(made)) == []


def test_a_moved_way_point_is_followed_from_the_one_before_it(owner):
    start = np.array(owner.matrix_world.translation)
    away = np.array(bpy.data.objects["Sofa"].matrix_world.translation) - start
    for share in (0.3, 0.6):
        bpy.context.scene.cursor.location = start + share * away * [1, 1, 0]
        bpy.ops.samp.add_waypoint()
    take = sat(owner)
    second = bpy.data.objects["Way-point 2"]
    second.location.x += 0.3
    (change,) = following.changes(bpy.context, origin.read(take))
    assert change.waypoint == 1 and change.distance == pytest.approx(0.3, abs=1e-4)
    frame, _ = following.first_frame(bpy.context, owner, take)
    passed = redo.passing(origin.read(take), shown(owner, take))
    assert passed[0] + 1 <= frame < passed[1] + 1
    bpy.ops.samp.follow_goal(action_name=take.name)
    made = owner.animation_data.action
    old, new = keys(take, owner, frame), keys(made, owner, frame)
    assert all(new[path] == old[path] for path in old)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"use_frame": True, "frame": 9000}, "is not within"),
        ({"action_name": "nothing"}, "There is no take 'nothing'"),
    ],
)
def test_refusals(owner, options, message):
    sat(owner)
    count = len(bpy.data.actions)
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.samp.redo_from_here(**options)
    assert len(bpy.data.actions) == count


def test_an_edited_copy_is_refused(owner):
    take = sat(owner)
    bpy.ops.samp.retime_take(action_name=take.name, walk=1.5)
    with pytest.raises(RuntimeError, match="was made is not known"):
        bpy.ops.samp.redo_from_here(use_frame=True, frame=10)


def test_a_take_follows_by_itself_once(owner):
    take = sat(owner)
    bpy.context.view_layer.objects.active = owner
    assert watching.follow() is None and owner.animation_data.action == take
    bpy.data.objects["Sofa"].location.x += 0.4
    assert watching.follow() is None
    made = owner.animation_data.action
    assert made != take and following.changes(bpy.context, origin.read(made)) == []
    count = len(bpy.data.actions)
    bpy.data.objects["Sofa"].location.z += 50  # out of reach
    for _ in range(2):
        assert watching.follow() is None and len(bpy.data.actions) == count
    assert owner.animation_data.action == made
