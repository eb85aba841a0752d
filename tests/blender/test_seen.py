"""Characters and furniture that something else moves are refused; what constraints show is what is measured."""

import bpy
import numpy as np
import pytest
from samp_blender.samp_addon.blender.actions import keyframes
from samp_blender.samp_addon.blender.character import character
from samp_blender.samp_addon.blender.takes import seen
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.motion import Motion


@pytest.fixture
def owner():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.context.scene.render.fps = 30
    return character.create_character(bpy.context, location=(-1, -1, 0))


def keyed(obj):
    for frame, x in ((1, -1.0), (60, 2.0)):
        obj.location = (x, -1, 0)
        obj.keyframe_insert("location", frame=frame)
    bpy.context.scene.frame_set(1)


def strip(owner):
    keyed(owner)
    action = owner.animation_data.action
    owner.animation_data.nla_tracks.new().strips.new("Walk", 1, action)
    owner.animation_data.action = None


def parent(owner):
    cart = bpy.data.objects.new("Cart", None)
    bpy.context.scene.collection.objects.link(cart)
    keyed(cart)
    owner.parent = cart


def driver(owner):
    owner.driver_add("location", 0).driver.expression = "frame * 0.05 - 1"


def constraint(owner):
    parent(owner)
    cart, owner.parent = owner.parent, None
    owner.constraints.new("COPY_LOCATION").target = cart


MOVERS = {
    strip: "a strip in its NLA",
    parent: "its parent 'Cart'",
    driver: "a driver",
    constraint: "its constraint",
}


@pytest.mark.parametrize("move", MOVERS)
def test_a_moved_character_is_refused(owner, move):
    move(owner)
    frame = bpy.context.scene.frame_current
    with pytest.raises(SampError, match=f"'{owner.name}' moves between .*{MOVERS[move]}"):
        seen.require_still(bpy.context, owner)
    assert bpy.context.scene.frame_current == frame


def test_a_moved_chair_is_refused_and_still_ones_are_not(owner):
    chair = bpy.data.objects.new("Chair", None)
    bpy.context.scene.collection.objects.link(chair)
    seen.require_still(bpy.context, owner, [chair])
    owner.delta_location = (0, -0.7, 0)
    keyed(owner)  # its own Action is replaced by the take
    seen.require_still(bpy.context, owner, [chair])
    keyed(chair)
    with pytest.raises(SampError, match="'Chair' moves"):
        seen.require_still(bpy.context, owner, [chair])


def motion():
    rotations = np.zeros((12, 22, 4))
    rotations[..., 0] = 1
    root = np.tile([0.3, 0.95, 0.2], (12, 1))
    root[:, 2] += np.linspace(0, 0.4, 12)
    return Motion(root, rotations)


def test_without_other_influences_the_keys_are_what_is_shown(owner):
    action = keyframes.write_motion(owner, motion(), "take", 1, bpy.context.scene)
    found, off = seen.shown_motion(bpy.context, owner, action)
    np.testing.assert_allclose(found.root, motion().root, atol=1e-5)
    assert off == []


@pytest.mark.parametrize("shift", [0.0, 0.5])
def test_what_a_constraint_shows_is_measured(owner, shift):
    action = keyframes.write_motion(owner, motion(), "take", 1, bpy.context.scene)
    bone = owner.pose.bones[next(b.name for b in owner.pose.bones if b.name.endswith("pelvis"))]
    limit = bone.constraints.new("TRANSFORM")
    limit.target = owner
    anchor = bpy.data.objects.new("Anchor", None)
    bpy.context.scene.collection.objects.link(anchor)
    limit.target, limit.map_from, limit.map_to = anchor, "LOCATION", "LOCATION"
    limit.to_min_x = limit.to_max_x = shift
    limit.target_space = limit.owner_space = "WORLD"
    limit.mix_mode = "ADD"
    found, off = seen.shown_motion(bpy.context, owner, action)
    away = np.linalg.norm(found.root - motion().root, axis=-1)
    np.testing.assert_allclose(away, shift, atol=1e-3)
    assert len(off) == (shift > 0)
    assert all("constraint" in text for text in off)


def test_a_carried_character_is_measured_where_it_is_shown(owner):
    action = keyframes.write_motion(owner, motion(), "take", 1, bpy.context.scene)
    driver(owner)
    bpy.context.scene.frame_set(1)
    found, off = seen.shown_motion(bpy.context, owner, action)
    drift = found.root[:, 0] - found.root[0, 0]
    np.testing.assert_allclose(drift, 0.05 * np.arange(12), atol=1e-3)
    assert "driver" in off[0]
