"""A rig of another kind as the character: takes go straight onto it."""

from __future__ import annotations

import bpy
import humanoids
import numpy as np
import pytest
import rooms
from samp_blender.samp_addon import frames
from samp_blender.samp_addon.blender.actions import notes
from samp_blender.samp_addon.blender.rigs import carry_to_rig, performers
from samp_blender.samp_addon.blender.takes import baking
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.pipeline.cast.cast import Cast, Member
from samp_blender.samp_addon.pipeline.job import Job
from samp_blender.tests.support.blender import rigs

KINDS = ("mixamo", "unreal 5")


pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def start():
    """A room with a chair; where a character starts in it: x, y, z and yaw in degrees."""
    return rooms.to_blender(rooms.random_room(3, rooms.chair), rigs.reset())


def rig_at(kind, start, name="Rig"):
    """Return a dressed rig that stands at a start."""
    rig = humanoids.make(kind, name)
    rig.location = np.array(start[:3]) + np.array(rig.location)
    rig.rotation_euler.rotate_axis("Z" if abs(rig.rotation_euler.x) < 1 else "Y", np.radians(start[3]))
    bpy.context.view_layer.update()
    humanoids.dress(rig, carry_to_rig.bones_of(rig)[1])
    bpy.context.view_layer.update()
    return rig


def pelvis_at(rig, frame):
    """Return where the hips of a rig are in a frame, network frame."""
    bpy.context.scene.frame_set(frame)
    bone = carry_to_rig.bones_of(rig)[1]["pelvis"]
    shown = rig.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return frames.to_network(np.array((shown.matrix_world @ shown.pose.bones[bone].matrix).translation))


@pytest.mark.parametrize("kind", KINDS)
def test_a_take_goes_straight_onto_a_rig(start, kind):
    rig = rig_at(kind, start)
    before = set(bpy.data.objects)
    place, yaw = performers.standing_floor(rig)
    assert np.abs(place - frames.to_network(np.array(start[:3]))).max() < 0.1
    assert np.degrees(abs(frames.wrap_angle(yaw - np.radians(start[3])))) < 5
    made = baking.run(bpy.context, Job(action="sit", target="Chair", character="Rig"), start_from="MARKER")
    assert made.owner == rig and rig.animation_data.action == made.actions[0]
    assert notes.is_take(made.actions[0]) and made.variants[0]["armature"] == "Rig"
    assert {obj.name for obj in set(bpy.data.objects) - before} <= {"Start of Rig"}, "no human beside it"
    first, last = (int(frame) for frame in made.actions[0].frame_range)
    begin, end = pelvis_at(rig, first), pelvis_at(rig, last)
    assert np.linalg.norm((begin - place)[[0, 2]]) < 0.15
    goal = frames.to_network(np.array(made.variants[0]["goal_position"]))
    assert np.linalg.norm((end - goal)[[0, 2]]) < 0.15 and 0.3 < end[1] < 0.8
    again = baking.run(
        bpy.context, Job(action="sit", target="Chair", character="Rig", seed=1), start_from="MARKER"
    )
    assert np.linalg.norm((pelvis_at(rig, int(again.actions[0].frame_range[0])) - begin)[[0, 2]]) < 0.15


def test_a_rig_is_no_furniture(start):
    """It stands where it starts; its own mesh would be in its way."""
    rig_at("mixamo", start)
    plan = baking.read(bpy.context, Job(action="walk", to=(0.0, -3.0, 0.0), character="Rig"))
    assert not [name for name in plan.geometry.names if "Rig" in name or "rig" in name]


def test_an_unknown_armature_is_refused(start):
    bone = bpy.data.armatures.new("Lamp")
    obj = bpy.data.objects.new("Lamp", bone)
    bpy.context.scene.collection.objects.link(obj)
    with pytest.raises(SampError, match="'Lamp' is not an SMPL-X armature"):
        baking.read(bpy.context, Job(action="sit", target="Chair", character="Lamp"))


@pytest.mark.parametrize(
    ("job", "start_from", "what"),
    [({"hand": ("left=Chair",)}, "STANDING", "a hand"), ({}, "POSE", "Start from Pose")],
)
def test_what_rigs_do_not_have_is_said(start, job, start_from, what):
    rig_at("mixamo", start)
    with pytest.raises(SampError, match=f"'Rig' is not an SMPL-X armature, which {what}"):
        baking.read(
            bpy.context, Job(action="sit", target="Chair", character="Rig", **job), start_from=start_from
        )


def test_a_cast_of_a_rig_and_a_human(start):
    from samp_blender.samp_addon.blender.cast import baking as cast_baking

    rig = rig_at("mixamo", start)
    jobs = [Job(action="sit", target="Chair", character="Rig"), Job(action="walk", to=(0.0, -3.0, 0.0))]
    members = tuple(Member(job=job, name=f"Member {k}") for k, job in enumerate(jobs))
    made = cast_baking.run(bpy.context, Cast(members))
    assert made.owners[0] == rig and rig.animation_data.action is not None


def test_the_batch_plays_takes_on_a_rig(start, tmp_path):
    """With a preview; files of SMPL-X parameters are refused."""
    from samp_blender.samp_addon.batch import main

    rig_at("mixamo", start)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "room.blend"))
    job = [
        "--scene",
        str(tmp_path / "room.blend"),
        "--character",
        "Rig",
        "--action",
        "sit",
        "--target",
        "Chair",
    ]
    common = [*job, "--report", str(tmp_path / "report.json")]
    assert (
        main.main([*common, "--output", str(tmp_path / "out.blend"), "--preview", str(tmp_path / "sheets")])
        == 0
    )
    assert list((tmp_path / "sheets").glob("*.png"))
    assert main.main([*common, "--npz", str(tmp_path / "takes")]) != 0
    assert "which --npz needs" in (tmp_path / "report.json").read_text()
