"""Takes blended with other Actions, as strips at the playhead, with markers, and with trails."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
import recordings
from samp_blender.samp_addon.blender.actions import keyframes, notes
from samp_blender.samp_addon.blender.character import character
from samp_blender.samp_addon.blender.edits import blending
from samp_blender.samp_addon.blender.overlays import trails
from samp_blender.samp_addon.edits.blending import blended

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def owner():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.context.scene.render.fps = 30
    made = character.create_character(bpy.context)
    keyframes.write_motion(made, recordings.walk(60, turn=0.7), "idle", 5)
    keyframes.write_motion(made, recordings.walk(90), "walk", 11)
    return made


@pytest.mark.parametrize(("order", "start"), [("AFTER", 11), ("BEFORE", 11 - 48)])
def test_blend_take(owner, order, start):
    motions = [keyframes.read_motion(owner, bpy.data.actions[name]) for name in ("walk", "idle")]
    options = {"action_name": "walk", "other": "idle", "order": order, "frames": 12}
    assert bpy.ops.samp.blend_take(**options) == {"FINISHED"}
    made = owner.animation_data.action
    assert made.name == "walk blended" and tuple(made.frame_range) == (start, start + 137)
    wanted = blended(*reversed(motions), 12, True) if order == "BEFORE" else blended(*motions, 12)
    again = keyframes.read_motion(owner, made)
    np.testing.assert_allclose(again.root, wanted.motion.root, atol=1e-4)
    for name, motion in zip(("walk", "idle"), motions, strict=True):
        assert np.array_equal(keyframes.read_motion(owner, bpy.data.actions[name]).root, motion.root)


@pytest.mark.parametrize(
    ("other", "frames", "message"),
    [
        ("nothing", 10, "There is no Action 'nothing'"),
        ("empty", 10, "does not animate"),
        ("idle", 99, "choose from 1"),
    ],
)
def test_blend_take_refuses(owner, other, frames, message):
    bpy.data.actions.new("empty")
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.samp.blend_take(action_name="walk", other=other, frames=frames)


def test_a_take_becomes_a_strip_at_the_playhead(owner):
    walk, data = bpy.data.actions["walk"], owner.animation_data
    bpy.context.scene.frame_set(101)
    assert bpy.ops.samp.take_to_strip(action_name="idle") == {"FINISHED"}
    assert data.action == walk  # that of another take stays
    assert bpy.ops.samp.take_to_strip(action_name="walk") == {"FINISHED"}
    assert data.action is None
    first, second = (track.strips[0] for track in data.nla_tracks)
    assert (first.frame_start, first.frame_end) == (101, 160) and second.action == walk
    motion = keyframes.read_motion(owner, walk)
    bpy.context.scene.frame_set(131)
    shown = owner.evaluated_get(bpy.context.evaluated_depsgraph_get())
    pelvis = owner.matrix_world @ shown.pose.bones["pelvis"].head
    assert np.linalg.norm(np.array(pelvis)[:2] - motion.root[30, [0, 2]] * [1, -1]) < 1e-3


def test_markers_travel_with_the_action_and_the_artists_stay(owner):
    walk = bpy.data.actions["walk"]
    own = walk.pose_markers.new("Mine")
    own.frame = 30
    for _ in range(2):
        assert bpy.ops.samp.mark_take(action_name="walk", steps=True) == {"FINISHED"}
        names = [marker.name for marker in walk.pose_markers]
        assert names.count("Mine") == 1 and names.count("Walk") == 1
        assert {marker.frame for marker in walk.pose_markers if marker.name == "Walk"} == {11}
        assert len([name for name in names if name.endswith("Step")]) >= 4
    assert bpy.ops.samp.mark_take(action_name="walk", phases=False) == {"FINISHED"}
    assert [marker.name for marker in walk.pose_markers] == ["Mine"]


def test_trails_of_the_active_take_are_kept_until_it_changes(owner):
    found = trails.of_owner(bpy.context, owner)
    assert len(found.points) == 3 * 89 and trails.of_owner(bpy.context, owner) is found
    owner.animation_data.action = None
    assert trails.of_owner(bpy.context, owner) is None
    assert not notes.is_take(owner.animation_data.action)


def test_a_blend_can_be_made_by_the_function(owner):
    made, found = blending.blend(bpy.context, owner, bpy.data.actions["walk"], bpy.data.actions["idle"], 10)
    assert found.last - found.first == 9 and owner.animation_data.action == made
