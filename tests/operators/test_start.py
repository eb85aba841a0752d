"""Where takes start: at the character's marker, however far the playhead is, or in the current pose."""

from __future__ import annotations

import math

import bpy
import fakes
import numpy as np
import pytest
import rooms
from samp_blender.samp_addon import frames
from samp_blender.samp_addon.blender.actions import keyframes
from samp_blender.samp_addon.blender.character import armature, character, start
from samp_blender.samp_addon.blender.overlays import start_marker
from samp_blender.samp_addon.blender.takes import baking
from samp_blender.samp_addon.methods.samp import networks
from samp_blender.samp_addon.methods.samp.networks import Networks
from samp_blender.samp_addon.pipeline.job import Job
from samp_blender.tests.support.blender import rigs

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def asked(monkeypatch):
    """The requests of all takes that were generated."""
    requests = []

    def generate(batch, progress=lambda share: None):
        requests.extend(batch)
        return fakes.generate(batch, progress)

    monkeypatch.setattr(networks, "trained", lambda: Networks(fakes.sample_goals, generate))
    return requests


@pytest.fixture
def owner():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.context.scene.render.fps = 30
    made = rooms.to_blender(rooms.random_room(1, rooms.sofa), bpy.context.scene)
    bpy.context.view_layer.update()
    bpy.ops.samp.create_character(location=tuple(made[:3]), yaw=1.0)
    return bpy.data.objects["Human"]


def press(**options):
    assert bpy.ops.samp.sit_here(target="Sofa", **options) == {"FINISHED"}


def starts(requests):
    return np.array([[*request.start_position, request.start_yaw] for request in requests])


def test_five_presses_start_at_the_same_place(owner, asked):
    """Also after each take was watched to its end."""
    for _ in range(5):
        press()
        bpy.context.scene.frame_set(round(owner.animation_data.action.frame_range[1]))
    found = starts(asked)
    assert len(found) == 5 and np.abs(found - found[0]).max() < 1e-6
    assert found[0, 3] == pytest.approx(1.0, abs=1e-5)
    assert len({request.seed for request in asked}) == 5


@pytest.mark.parametrize("family", ["mpi", "meshcapade"])
def test_first_take_of_an_armature_stores_its_start(owner, asked, family):
    other = rigs.make(family, name="Other")
    other.matrix_world = owner.matrix_world @ other.matrix_world
    for part in (*owner.children, owner):  # so that its start is free
        bpy.data.objects.remove(part)
    assert start.stored(other) is None
    for _ in range(3):
        press(character="Other")
        bpy.context.scene.frame_set(round(other.animation_data.action.frame_range[1]))
    found = starts(asked)
    assert np.abs(found - found[0]).max() < 1e-5
    assert start_marker.find(other).parent == other


def test_take_of_another_file_starts_where_it_began(owner, asked):
    """A character from the batch has no marker: its active take says where it started."""
    baking.run(bpy.context, Job(target="Sofa"), tools=fakes.TOOLS)
    before = armature.standing_floor(owner)
    del owner[start.START_KEY]
    bpy.data.objects.remove(start_marker.find(owner))
    bpy.context.scene.frame_set(round(owner.animation_data.action.frame_range[1]))
    place, _ = start.first_start(owner)
    assert np.abs(place[[0, 2]] - before[0][[0, 2]]).max() < 0.05


def test_marker_is_dragged(owner, asked):
    marker = start_marker.find(owner)
    assert marker.hide_render and marker.parent == owner
    marker.location.x += 0.25
    marker.rotation_euler.rotate_axis("X", math.radians(90))
    press()
    press(use_start=True, start=(3, 3, 0), start_yaw=0.5)
    moved, own = starts(asked)
    there = frames.to_network(np.array(marker.matrix_world.translation))
    assert np.abs(moved[[0, 2]] - there[[0, 2]]).max() < 1e-5
    assert abs(math.degrees(moved[3] - 1.0)) == pytest.approx(90, abs=0.1)
    assert own[3] == pytest.approx(0.5) and np.abs(own[[0, 2]] - [3, -3]).max() < 0.05


def test_start_moves_with_the_character_and_can_be_set(owner, asked):
    press()
    owner.location.x += 0.5
    press()
    found = starts(asked)
    assert np.abs(found[1] - found[0] - [0.5, 0, 0, 0]).max() < 1e-4
    bpy.context.scene.frame_set(round(owner.animation_data.action.frame_range[1]))
    assert bpy.ops.samp.set_start() == {"FINISHED"}
    place, _ = start_marker.place(bpy.context, owner)
    assert np.abs(place - armature.standing_floor(owner)[0]).max() < 1e-5


def test_batch_starts_where_the_character_stands(owner, asked):
    start_marker.find(owner).location.x += 1.0
    tools = fakes.toolbox(networks.trained().generate)
    baking.run(bpy.context, Job(target="Sofa"), tools=tools)
    assert np.abs(starts(asked)[0, :3] - armature.standing_floor(owner)[0]).max() < 0.6
    assert starts(asked)[0, 3] == pytest.approx(1.0, abs=1e-5)


def test_continue_from_here_begins_in_the_pose_at_the_frame(owner, asked):
    """The next take begins at the current frame, in the pose that is shown, and with the motion so far."""
    scene = bpy.context.scene
    press()
    first = owner.animation_data.action
    scene.samp.start_from = "POSE"
    scene.frame_set(round(first.frame_range[1]))
    bpy.context.view_layer.update()
    shown = armature.posed(owner)
    assert bpy.ops.samp.walk_here(location=(-3, -3, 0)) == {"FINISHED"}
    second = owner.animation_data.action
    assert second != first and second.frame_range[0] == first.frame_range[1]
    assert asked[-1].after is not None and len(asked[-1].after) > 30
    bpy.context.view_layer.update()
    again = armature.posed(owner)
    joints = [motion.forward_kinematics()[0][0] for motion in (shown, again)]
    assert np.abs(joints[0] - joints[1]).max() < 1e-3
    # The stored start is still the first one.
    assert start_marker.place(bpy.context, owner)[1] == pytest.approx(1.0, abs=1e-5)


def test_continue_from_a_pose_of_ones_own(owner, asked):
    """A pose without a take is the first frame; the walk starts under it."""
    scene = bpy.context.scene
    scene.samp.start_from = "POSE"
    scene.frame_set(1040)
    owner.pose.bones["left_elbow"].rotation_quaternion = (0.8, 0.0, 0.6, 0.0)
    bpy.context.view_layer.update()
    shown = armature.posed(owner).forward_kinematics()[0][0]
    press()
    action = owner.animation_data.action
    assert action.frame_range[0] == 1040 and asked[-1].after is None
    take = keyframes.read_motion(owner, action)
    assert np.abs(take.forward_kinematics()[0][0, :22] - shown[:22]).max() < 1e-3


def test_posed_equals_the_take(owner, asked):
    press()
    action = owner.animation_data.action
    take = keyframes.read_motion(owner, action)
    for frame in (1, 20, 60):
        bpy.context.scene.frame_set(frame)
        found = armature.posed(owner).forward_kinematics()[0][0]
        assert np.abs(found - take.forward_kinematics()[0][frame - 1]).max() < 1e-4


def test_new_character_of_a_press_has_a_marker(owner, asked):
    bpy.data.objects.remove(start_marker.find(owner))
    bpy.data.objects.remove(owner)
    press()
    made = bpy.context.scene.samp.character
    assert start_marker.find(made) is not None
    press()
    found = starts(asked)
    assert np.abs(found[1] - starts(asked)[1]).max() < 1e-6
    stood = character.calibrate(made).rest_joints[:, 1].min()
    assert abs(start_marker.place(bpy.context, made)[0][1] - stood - 0.9) < 1.0
