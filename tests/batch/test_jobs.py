"""Jobs in Blender: what they write, what they leave alone, and what they leave behind when they stop."""

from __future__ import annotations

import json
from dataclasses import replace

import bpy
import fakes
import numpy as np
import pytest
import rooms
from samp_blender.samp_addon.blender.actions import keyframes, notes
from samp_blender.samp_addon.blender.character import armature, character
from samp_blender.samp_addon.blender.takes import baking, reporting
from samp_blender.samp_addon.body import human
from samp_blender.samp_addon.errors import SampError, UsageError
from samp_blender.samp_addon.pipeline.job import Job

SIT = Job(action="sit", target="Sofa", variants=2, seed=5, hold=1.5)


@pytest.fixture
def start():
    """A file with a room of boxes; the start as the batch takes it."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    made = rooms.to_blender(rooms.random_room(1, rooms.sofa), bpy.context.scene)
    bpy.context.view_layer.update()
    return tuple(made)


def everything():
    """All that could be left behind, and the objects' places."""
    data = bpy.data
    kinds = (data.objects, data.meshes, data.armatures, data.actions, data.materials, data.collections)
    places = {obj.name: [round(v, 6) for row in obj.matrix_world for v in row] for obj in data.objects}
    return [sorted(item.name for item in kind) for kind in kinds], places


def run(job, **keywords):
    return baking.run(bpy.context, job, tools=fakes.TOOLS, **keywords)


def test_each_take_is_an_action_and_the_first_is_active(start):
    result = run(replace(SIT, start=start))
    assert [action.name for action in result.actions] == ["sit Sofa 5", "sit Sofa 6"]
    assert result.owner.animation_data.action == result.actions[0]
    assert all(action.use_fake_user for action in result.actions)


def test_the_report_tells_what_the_armature_shows(start):
    bpy.context.scene.render.fps, bpy.context.scene.frame_start = 24, 11
    result = run(replace(SIT, start=start))
    report = json.loads(json.dumps(reporting.report(result.variants)))
    assert report["schema_version"] == 2
    for variant, action in zip(report["variants"], result.actions, strict=True):
        keyframes.activate_action(result.owner, action)
        bpy.context.scene.frame_set(variant["frame_end"])
        pelvis = result.owner.matrix_world @ result.owner.pose.bones["pelvis"].head
        assert np.linalg.norm(np.subtract(pelvis, variant["goal_position"])) < 0.08
        bpy.context.scene.frame_set(variant["frame_start"])
        pelvis = result.owner.matrix_world @ result.owner.pose.bones["pelvis"].head
        assert np.hypot(pelvis[0] - start[0], pelvis[1] - start[1]) < 0.05
        assert variant["frame_start"] == 11
        assert variant["frame_start"] < variant["interaction_start"] < variant["frame_end"]
        assert (variant["action"], variant["target"], variant["fps"]) == ("sit", "Sofa", 24)
        assert (variant["armature"], variant["action_name"]) == (result.owner.name, action.name)
        assert np.linalg.norm(variant["goal_direction"]) == pytest.approx(1, abs=1e-5)
        assert variant["goal_direction"][2] == 0
        np.testing.assert_allclose(variant["waypoints"][0][:2], start[:2], atol=0.05)
        assert variant["metrics"]["success"] is True
        assert {"position_error_cm", "foot_slide_cm_s", "penetration_2cm_percent"} <= set(variant["metrics"])
        assert {"goal", "path", "rollout", "measure"} <= set(variant["seconds"])
        assert variant["seconds"]["measure"] > 0
        assert variant["warnings"] == notes.read_warnings(bpy.data.actions[variant["action_name"]])


@pytest.mark.parametrize("shape", [{"height": 1.6, "gender": 0.0}, {"height": 1.95, "weight": 100.0}])
def test_the_human_that_is_made_has_the_shape(start, shape):
    result = run(Job(action="idle", start=start, shape=shape, hold=1.5))
    body = character.body_of(result.owner)
    assert body.height == pytest.approx(shape["height"], abs=0.01)
    (variant,) = result.variants
    assert variant["shape"] == shape
    motion = keyframes.read_motion(result.owner, result.actions[0])
    skin = human.skin(body, motion.pose_slice(slice(0, 1)))
    assert skin[..., 1].min() == pytest.approx(0.0, abs=0.02)


def test_the_artists_scene_is_left_alone(start):
    owner = character.create_character(bpy.context, location=(start[0], start[1], 0))
    owner.animation_data_create()
    own = bpy.data.actions.new("The artist's")
    keyframes.activate_action(owner, own)
    before = everything()
    run(SIT)
    after = everything()
    added = set(after[0][3]) - set(before[0][3])
    assert added == {"sit Sofa 5", "sit Sofa 6"}
    assert [a for k, a in enumerate(after[0]) if k != 3] == [b for k, b in enumerate(before[0]) if k != 3]
    assert after[1] == before[1]
    assert own.use_fake_user


def test_the_character_starts_where_it_stands(start):
    owner = character.create_character(bpy.context, location=(start[0], start[1], 0), yaw=1.0)
    variant = run(replace(SIT, variants=1)).variants[0]
    assert variant["armature"] == owner.name
    np.testing.assert_allclose(variant["waypoints"][0][:2], start[:2], atol=0.05)


def test_the_batch_makes_a_new_character_unless_one_is_named(start):
    character.create_character(bpy.context, location=(start[0], start[1], 0), name="Ann")
    job = replace(SIT, variants=1)
    new = run(job, new_character=True).owner
    assert new.name != "Ann"
    for part in (*new.children, new):  # it sits where Ann is to sit
        bpy.data.objects.remove(part)
    assert run(replace(job, character="Ann"), new_character=True).owner.name == "Ann"


def test_a_new_character_stands_at_the_start(start):
    owner = run(replace(SIT, start=start, variants=1)).owner
    np.testing.assert_allclose(owner.location[:2], start[:2], atol=0.05)
    assert armature.is_smplx(owner)


class Stop(Exception):
    pass


@pytest.mark.parametrize("stage", ["Finding the floor", "Moving", "Refining", "Writing keyframes"])
@pytest.mark.parametrize("own", [False, True])
def test_a_stopped_job_leaves_nothing_behind(start, stage, own):
    if own:
        character.create_character(bpy.context, location=(start[0], start[1], 0))
    before = everything()
    seen = []

    def progress(name, share):
        seen.append(name)
        # The second take's keyframes: those of the first are written.
        if name == stage and (stage != "Writing keyframes" or share > 0):
            raise Stop

    with pytest.raises(Stop):
        run(replace(SIT, start=start, refine=True), progress=progress)
    assert stage in seen
    assert everything() == before


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"target": "Soffa"}, "There is no 'Soffa'.*'Sofa'"),
        ({"target": "Floor"}, "sit"),
        ({"character": "Bob"}, "no object 'Bob'"),
        ({"character": "Sofa"}, "not an armature"),
        ({"start": (40.0, 40.0, 0.0, 0.0)}, "."),
    ],
)
def test_what_cannot_be_done_says_why_and_changes_nothing(start, changes, reason):
    before = everything()
    with pytest.raises(SampError, match=reason):
        run(replace(SIT, **changes))
    assert everything() == before


def test_stuck_takes_are_reported(start):
    with pytest.raises(SampError, match="stuck"):
        baking.run(bpy.context, replace(SIT, start=start), tools=fakes.STUCK)


def test_refined_takes_and_what_the_report_tells_of_them(start):
    seen = []
    plain = run(replace(SIT, start=start))
    result = run(
        replace(SIT, start=start, refine=True), progress=lambda stage, share: seen.append((stage, share))
    )
    shares = [share for stage, share in seen if stage == "Refining"]
    assert shares == sorted(shares) and len(set(shares)) == 4 and seen[-1][0] == "Measuring"
    for one, two, action in zip(plain.variants, result.variants, result.actions, strict=True):
        refined = json.loads(json.dumps(two["refined"]))
        assert refined["before"]["penetration_max_cm"] == 4 and refined["after"]["contact"] == 1
        assert (refined["unsolved_cm"], "refined" in one) == (4, False)
        raised = two["metrics"]["position_error_cm"] - one["metrics"]["position_error_cm"]
        assert 0 < abs(raised) <= 100 * fakes.RAISED + 1e-6
        assert "refine" in two["seconds"] and "refine" not in one["seconds"]
        lifted = [keyframes.read_motion(result.owner, a).root[-1, 1] for a in (action, plain.actions[0])]
        assert lifted[0] - lifted[1] > fakes.RAISED - 0.05
    assert "still 4 cm deep" in baking.sentence(result)


def listening(seen):
    def refine(motion, surroundings, goal, body, settings, progress):
        seen.append((motion, surroundings, goal, body))
        return fakes.refine(motion, surroundings)

    return replace(fakes.TOOLS, refine=refine)


@pytest.mark.parametrize("floor", [True, False])
def test_what_a_take_is_refined_against(start, floor):
    bpy.data.objects["Sofa"]["samp_cushion"] = 0.03
    if not floor:
        bpy.data.objects.remove(bpy.data.objects["Floor"])
    owner = character.create_character(bpy.context, {"tall": 1.0}, (start[0], start[1], 0))
    seen = []
    result = baking.run(bpy.context, replace(SIT, refine=True, variants=1), tools=listening(seen))
    ((motion, around, goal, body),) = seen
    assert around.give.max() == 0.03 and 0 < (around.give > 0).mean() < 1
    # Where a floor was assumed it has no triangles.
    assert around.floor == (None if floor else pytest.approx(0, abs=1e-6))
    remembered = notes.read_ground(result.actions[0])
    assert remembered == (None if floor else pytest.approx(0, abs=1e-6))
    np.testing.assert_allclose(body.joints, armature.calibrate(owner).rest_joints, atol=1e-6)
    np.testing.assert_array_equal(motion.rest_joints, body.joints)
    assert goal.action == "sit"


def test_a_take_that_cannot_be_refined_is_kept_and_reported(start):
    def fail(*arguments):
        raise SampError("Nothing stands near.")

    tools = replace(fakes.TOOLS, refine=fail)
    result = baking.run(bpy.context, replace(SIT, start=start, refine=True), tools=tools)
    assert len(result.actions) == 2 and "refined" not in result.variants[0]
    assert [failure.message for failure in result.failures] == [
        "The take is not refined: Nothing stands near."
    ] * 2


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"action": "dance"}, "no action 'dance'"),
        ({"action": "sit"}, "--target"),
        ({"action": "walk"}, "--to"),
        ({"action": "walk", "to": (1.0,)}, "X Y Z"),
        ({"action": "walk", "to": (1.0, float("nan"), 0.0)}, "X Y Z"),
        ({"action": "sit", "target": "Sofa", "to": (0.0, 0.0, 0.0)}, "--to is for"),
        ({"action": "idle", "start": (0.0, 0.0, 0.0)}, "X Y Z YAW"),
        ({"action": "idle", "variants": 0}, "--variants"),
        ({"action": "idle", "seed": -1}, "--seed"),
        ({"action": "idle", "hold": -1.0}, "--hold"),
        ({"action": "idle", "method": "scene_gan", "target": "Sofa"}, "goes to no target"),
        ({"action": "idle", "method": "magic"}, "no method"),
    ],
)
def test_unusable_jobs(options, reason):
    with pytest.raises(UsageError, match=reason):
        Job(**options)
