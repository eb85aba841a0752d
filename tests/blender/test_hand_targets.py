"""Hands on objects of the scene, by the operator; contact is kept through Refine."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
import recordings
from samp_blender.samp_addon import frames
from samp_blender.samp_addon.blender.actions import keyframes, notes, refine_action
from samp_blender.samp_addon.blender.character import character
from samp_blender.samp_addon.blender.edits import hand_targets
from samp_blender.samp_addon.edits.hand_target import hand_target
from samp_blender.samp_addon.refine.hands.palm import palm

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def owner():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.context.scene.render.fps = 30
    made = character.create_character(bpy.context)
    keyframes.write_motion(made, recordings.walk(60, speed=0.0), "stand")
    return made


@pytest.fixture
def cup():
    """An empty in front of the character that is lifted and put down."""
    made = bpy.data.objects.new("Cup", None)
    bpy.context.scene.collection.objects.link(made)
    for frame, height in ((20, 1.1), (35, 1.3), (50, 1.1)):
        made.location = (-0.15, -0.4, height)
        made.keyframe_insert("location", frame=frame)
    return made


def palms(owner, side):
    motion = keyframes.read_motion(owner)
    return frames.to_blender(palm(*motion.forward_kinematics(), motion.rest_joints, side)[0])


def places(obj, first, last):
    found = []
    for frame in range(first, last + 1):
        bpy.context.scene.frame_set(frame)
        found.append(obj.matrix_world.translation.copy())
    return np.array(found)


def test_the_operator_does_what_the_function_does(owner, cup):
    before = owner.animation_data.action
    motion = keyframes.read_motion(owner)
    options = {"use_range": True, "frame_start": 20, "frame_end": 50, "ease": 0.3}
    assert bpy.ops.samp.hand_target(target="Cup", hand="right", **options) == {"FINISHED"}
    made = owner.animation_data.action
    assert made.name == "stand right hand" and notes.is_take(made) and made != before
    followed = places(cup, 1, 60)
    assert np.linalg.norm(palms(owner, "right")[19:50] - followed[19:50], axis=-1).max() < 0.01
    wanted = hand_target(motion, "right", frames.to_network(followed), 19, 49, 0.3).motion
    again = keyframes.read_motion(owner)
    same = np.sign((wanted.rotations * again.rotations).sum(-1, keepdims=True))
    np.testing.assert_allclose(same * again.rotations, wanted.rotations, atol=1e-5)
    assert np.array_equal(keyframes.read_motion(owner, before).rotations, motion.rotations)
    (hand,) = notes.read_hands(made, 1, 60)
    assert hand.side == "right" and hand.weight[19:50].min() == 1 and hand.weight[:8].max() == 0


@pytest.mark.parametrize("vertex", [-1, 3])
def test_a_mesh_is_touched_at_a_vertex_or_where_it_is_nearest(owner, vertex):
    bpy.ops.mesh.primitive_plane_add(size=0.3, location=(0.25, -0.35, 1.05))
    table = bpy.context.object
    assert bpy.ops.samp.hand_target(character=owner.name, target=table.name, hand="left", vertex=vertex) == {
        "FINISHED"
    }
    found = palms(owner, "left")
    if vertex < 0:
        assert np.abs(found[:, 2] - 1.05).max() < 0.01
    else:
        place = np.array(table.matrix_world @ table.data.vertices[vertex].co)
        assert np.linalg.norm(found - place, axis=-1).max() < 0.01


def test_a_hand_rests_on_top_of_a_table_and_not_on_what_is_lower(owner):
    """A box with a top at 0.9 m, whose side is nearer to the hand, and a low bench below the knees."""
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0.75, -0.1, 0.45), scale=(0.7, 0.7, 0.9))
    made = hand_targets.bake(bpy.context, bpy.context.object, "left", owner.name)
    assert made.missed < 0.01 and np.abs(palms(owner, "left")[:, 2] - 0.9).max() < 0.01
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0.75, -0.1, 0.15), scale=(0.7, 0.7, 0.3))
    hand_targets.bake(bpy.context, bpy.context.object, "left", owner.name)
    (contact,) = notes.read_hands(owner.animation_data.action, 1, 60)
    assert contact.places[0, 1] == pytest.approx(0.3, abs=1e-3)  # the nearest point, by lack of a higher top


def test_contact_is_kept_through_refine(owner, cup):
    bpy.ops.mesh.primitive_plane_add(size=6)
    bpy.ops.samp.hand_target(
        character=owner.name, target="Cup", use_range=True, frame_start=20, frame_end=50, ease=0.3
    )
    source = owner.animation_data.action
    made = refine_action.run(bpy.context, owner.name).action
    assert made != source
    off = palms(owner, "right")[19:50] - places(cup, 20, 50)
    assert np.linalg.norm(off, axis=-1).max() < 0.01


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"target": "Nothing"}, "There is no 'Nothing'"),
        ({}, "Nothing else is selected"),
        ({"target": "Human"}, "moves with 'Human'"),
        ({"target": "Cup", "vertex": 3}, "has no vertices"),
        ({"target": "Cup", "use_range": True, "frame_start": 90, "frame_end": 95}, "no frames"),
    ],
)
def test_refusals(owner, cup, options, message):
    for obj in bpy.context.selected_objects:
        obj.select_set(False)
    count = len(bpy.data.actions)
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.samp.hand_target(character=owner.name, **options)
    assert len(bpy.data.actions) == count


def test_a_job_brings_hands_to_targets_while_it_is_baked(owner, cup):
    motion = recordings.walk(60, speed=0.0)
    made, (contact,), missed = hand_targets.applied(bpy.context, owner, motion, ("right=Cup:20-50",), 1)
    middle, _ = palm(*made.forward_kinematics(), made.rest_joints, "right")
    assert np.linalg.norm(frames.to_blender(middle)[19:50] - places(cup, 20, 50), axis=-1).max() < 0.01
    assert contact.weight[19:50].min() == 1 and missed == []
    same, none, told = hand_targets.applied(bpy.context, owner, motion, ("left=Nothing",), 1)
    assert none == [] and told == ["There is no 'Nothing' for the left hand."]
    assert np.array_equal(same.root, motion.root)


def test_what_is_out_of_reach_is_told(owner, cup):
    cup.animation_data_clear()
    cup.location = (0, -2.5, 1)
    made = hand_targets.bake(bpy.context, cup, "left", owner.name)
    assert made.missed > 1 and "misses 'Cup' by" in made.sentence()


@pytest.mark.parametrize("handle", [False, True])
def test_fingers_grasp_a_mug_or_the_mesh_that_an_empty_hangs_on(owner, handle):
    bpy.ops.mesh.primitive_cylinder_add(radius=0.035, depth=0.12, location=(-0.2, -0.35, 1.05))
    mug = bpy.context.object
    mug.name = "Mug"
    if handle:
        empty = bpy.data.objects.new("Handle", None)
        bpy.context.scene.collection.objects.link(empty)
        empty.parent, empty.location = mug, (-0.035, 0.0, 0.0)
    bpy.context.view_layer.objects.active = owner
    before = keyframes.read_motion(owner)
    options = {"use_range": True, "frame_start": 20, "frame_end": 50, "ease": 0.3, "grasp": True}
    assert bpy.ops.samp.hand_target(target="Handle" if handle else "Mug", hand="right", **options) == {
        "FINISHED"
    }
    made = keyframes.read_motion(owner)
    fingers = np.abs(made.rotations - before.rotations)[:, 40:].max(axis=(1, 2))  # of the right hand
    assert fingers[19:50].min() > 0.05 and fingers[[0, -1]].max() < 1e-4
    assert np.abs(made.rotations - before.rotations)[:, 25:40].max() < 1e-4


def test_an_empty_without_a_surface_cannot_be_grasped(owner, cup):
    before = owner.animation_data.action
    with pytest.raises(RuntimeError, match="'Cup' has no faces.*, or turn off Grasp\\."):
        bpy.ops.samp.hand_target(target="Cup", grasp=True)
    assert owner.animation_data.action == before
