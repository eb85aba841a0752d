"""Refinement of an Action with a fake optimiser: a new Action is added and the source does not change."""

from __future__ import annotations

import time
from dataclasses import replace
from types import SimpleNamespace

import bpy
import fakes
import numpy as np
import pytest
import rooms
from samp_blender.operators import refine as operator
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.blender import compat
from samp_blender.samp_addon.blender.actions import curve_keys, keyframes, notes, refine_action, rekeying
from samp_blender.samp_addon.blender.character import character
from samp_blender.samp_addon.blender.scene import read_scene
from samp_blender.samp_addon.blender.thread_run import Cancelled
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.motion import Goal, Motion
from samp_blender.samp_addon.refine import refinement as optimiser
from samp_blender.samp_addon.refine.refinement import Settings
from samp_blender.tests.support.blender import rigs
from screen import Screen

FRAMES = 60
KNEE = 'pose.bones["left_knee"].rotation_quaternion'


pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture(autouse=True)
def _fake_optimiser(monkeypatch):
    monkeypatch.setattr(optimiser, "refine", fakes.refine)


@pytest.fixture
def owner():
    """Add a human with a take to a room."""
    rigs.reset()
    rooms.to_blender(rooms.random_room(1, rooms.sofa), bpy.context.scene)
    made = character.create_character(bpy.context)
    keyframes.write_motion(made, take(), "Take")
    notes.write_goal(made.animation_data.action, Goal(np.array([0, 0.9, 1]), np.array([0, 0, 1.0])))
    return made


def take(**changes):
    """Return a motion that sways in place with bending knees."""
    at = np.arange(FRAMES) / 30
    quats = np.tile([1.0, 0, 0, 0], (FRAMES, 22, 1))
    for side in ("left", "right"):
        bend = np.stack([0.4 + 0.3 * np.sin(3 * at), 0 * at, 0 * at], axis=1)
        quats[:, skeleton.INDEX[f"{side}_knee"]] = rotation.from_axis_angle(bend)
    root = np.stack([0.1 * np.sin(at), 0.9 + 0 * at, 0.2 * at], axis=1)
    return Motion(root, quats, **changes)


def action_of(owner):
    return owner.animation_data.action


def kept(action, owner):
    """Return the content of an Action for an armature, bit for bit."""
    curves = []
    for curve in compat.curves(action, owner):
        keys = curve_keys.CurveKeys.of(curve).values
        data = [(name, value.tobytes()) for name, value in keys.items()]
        curves.append((curve.data_path, curve.array_index, curve.extrapolation, len(curve.modifiers), data))
    notes = {key: str(getattr(value, "to_dict", lambda v=value: v)()) for key, value in action.items()}
    return action.name, curves, notes


def curve_of(owner, path, index=0, action=None):
    action = action or action_of(owner)
    return next(c for c in compat.curves(action, owner) if (c.data_path, c.array_index) == (path, index))


def run(**options):
    return refine_action.run(bpy.context, **options)


def test_new_action_and_unchanged_source(owner):
    old = action_of(owner)
    before, shown = kept(old, owner), keyframes.read_motion(owner, old)
    new = run().action
    assert kept(old, owner) == before
    assert (new.name, action_of(owner)) == ("Take refined", new)
    assert old.use_fake_user and new.use_fake_user
    again = keyframes.read_motion(owner, new)
    wanted = fakes.refine(shown, SimpleNamespace(triangles=[0])).motion
    np.testing.assert_allclose(again.root, wanted.root, atol=1e-5)
    assert np.abs(np.sum(again.rotations * wanted.rotations, axis=-1)).min() > 1 - 1e-7
    assert notes.read_goal(new).position == pytest.approx([0, 0.9, 1])
    assert (new["samp"]["frame_end"], tuple(new.frame_range)) == (FRAMES, (1, FRAMES))


def test_unchanged_channels_keep_their_keys(owner):
    right = 'pose.bones["right_knee"].rotation_quaternion'
    old, new = action_of(owner), run().action
    for path, same in ((right, True), (KNEE, False)):
        pair = [kept(action, owner)[1] for action in (old, new)]
        assert ([c for c in pair[0] if c[0] == path] == [c for c in pair[1] if c[0] == path]) is same


def test_named_action_that_is_not_active(owner):
    keyframes.write_motion(owner, take(), "Other")
    result = run(action_name="Take", character="Human")
    assert (result.action.name, action_of(owner)) == ("Take refined", result.action)
    assert all(bpy.data.actions[name].use_fake_user for name in ("Take", "Other"))


@pytest.mark.skipif(not compat.SLOTTED, reason="before Blender 4.4 no Action holds curves for two")
def test_action_shared_with_another_character(owner):
    other = character.create_character(bpy.context, name="Other")
    action = keyframes.write_motion(other, take(), "Both")
    writer = compat.CurveWriter(action, owner)
    writer.add('pose.bones["pelvis"].location', 0, np.array([1.0, 9.0]), np.zeros(2), "pelvis")
    other.name = "Renamed"
    before = {obj: kept(action, obj)[1] for obj in (owner, other)}
    assert before[owner] != before[other]
    bpy.context.view_layer.objects.active = other
    new = run().action
    assert kept(new, owner)[1] == before[owner]
    assert keyframes.read_motion(other).root[0, 1] == pytest.approx(
        take().root[0, 1] + fakes.RAISED, abs=1e-5
    )
    assert other.animation_data.action_slot.name_display == "Other"


@pytest.mark.parametrize("name", ["x" * 63, "ä" * 31, "Take"])
def test_names_are_unique_and_not_too_long(owner, name):
    action_of(owner).name = name
    made = []
    for _ in range(3):
        made.append(run(action_name=bpy.data.actions[0].name).action.name)
    assert len(set(made)) == 3
    assert all(len(label.encode()) <= 63 and " refined" in label for label in made)


# ------------------------------------------------------------------- a part of the Action


def hand_keyed(interpolation="BEZIER", every=7.0):
    """Replace the keys by sparse ones, some between frames."""

    def arrange(owner):
        for curve in compat.curves(action_of(owner), owner):
            at = np.append(np.arange(1, FRAMES, every), FRAMES)
            values = [curve.evaluate(time) for time in at]
            curve.keyframe_points.clear()
            for time_, value in zip(at, values, strict=True):
                key = curve.keyframe_points.insert(time_, value)
                key.interpolation = interpolation
            curve.update()

    return arrange


def with_cycles(owner):
    for curve in compat.curves(action_of(owner), owner):
        while len(curve.keyframe_points) > 20:
            curve.keyframe_points.remove(curve.keyframe_points[-1])
        curve.modifiers.new("CYCLES")
    note_keys(owner, 'pose.bones["jaw"].location', (1, FRAMES))


def straight_on(owner):
    for curve in compat.curves(action_of(owner), owner):
        while len(curve.keyframe_points) > 30:
            curve.keyframe_points.remove(curve.keyframe_points[-1])
        curve.extrapolation = "LINEAR"
    note_keys(owner, 'pose.bones["jaw"].location', (1, FRAMES))


def note_keys(owner, path, at):
    slot = getattr(owner.animation_data, "action_slot", None)  # there are none before Blender 4.4
    writer = compat.CurveWriter(action_of(owner), owner, slot)
    writer.add(path, 0, np.array(at), np.zeros(len(at)), "jaw")


@pytest.mark.parametrize("part", [(20, 40), (1, 25), (36, FRAMES), (22, 23), (8, 9)])
@pytest.mark.parametrize(
    "arrange",
    [
        lambda owner: None,
        hand_keyed(),
        hand_keyed(every=6.3),
        hand_keyed("LINEAR"),
        hand_keyed("CONSTANT"),
        with_cycles,
        straight_on,
    ],
    ids=["every frame", "sparse", "sub-frames", "linear", "constant", "cycles", "straight on"],
)
def test_part_is_faded_into_the_rest(owner, arrange, part):
    arrange(owner)
    old = action_of(owner)
    before, start, end = kept(old, owner), *part
    new = run(frame_start=start, frame_end=end).action
    assert kept(old, owner) == before
    frames = np.arange(1, FRAMES + 1)
    outside = (frames < start) | (frames > end)
    one, two = (keyframes.read_motion(owner, action, 1, FRAMES) for action in (old, new))
    change = two.root[:, 1] - one.root[:, 1]
    assert np.abs(two.root - one.root)[outside].max() < 1e-5
    assert np.abs(two.rotations - one.rotations)[outside].max() < 1e-5
    assert change.max() == pytest.approx(fakes.RAISED if end - start > 10 else change.max(), abs=1e-5)
    assert np.abs(np.diff(change)).max() < fakes.RAISED / 3
    # No fade at the ends of the Action.
    assert change[0] == pytest.approx(fakes.RAISED if start == 1 else 0, abs=1e-5)
    assert change[-1] == pytest.approx(fakes.RAISED if end == FRAMES else 0, abs=1e-5)


@pytest.mark.parametrize("arrange", [hand_keyed(), hand_keyed("LINEAR"), hand_keyed("CONSTANT")])
def test_keys_and_values_outside_the_part_do_not_change(owner, arrange):
    arrange(owner)
    old = action_of(owner)
    new = run(frame_start=30, frame_end=40).action
    for index in range(4):
        one, two = (curve_of(owner, KNEE, index, action) for action in (old, new))
        times = np.append(np.arange(1, 29, 0.25), np.arange(44, FRAMES, 0.25))
        whole = [key.co.x for key in one.keyframe_points if not 29 <= key.co.x <= 40]
        assert set(whole) <= {key.co.x for key in two.keyframe_points}
        kept_apart = times[(times <= 22) | (times >= 43)]
        values = [[curve.evaluate(t) for t in kept_apart] for curve in (one, two)]
        np.testing.assert_allclose(*values, atol=2e-6)


@pytest.mark.parametrize(("part", "aimed"), [((1, 40), False), ((30, FRAMES), True), ((None, None), True)])
def test_goal_is_used_if_the_part_includes_the_end(owner, part, aimed):
    note_keys(owner, 'pose.bones["jaw"].location', (1, FRAMES + 30))
    plan = refine_action.read(bpy.context, "", "", *part)
    assert (plan.goal is not None) is aimed


# --------------------------------------------------------------- channels outside the Motion


def test_other_bones_and_channels_are_copied(owner):
    bpy.ops.object.mode_set(mode="EDIT")
    hat = owner.data.edit_bones.new('a "hat"')
    hat.head, hat.tail, hat.parent = (0, 0, 1.8), (0, 0, 2), owner.data.edit_bones["head"]
    bpy.ops.object.mode_set(mode="OBJECT")
    owner["mood"] = 1.0
    for bone, path in ((owner.pose.bones['a "hat"'], "location"), (owner.pose.bones["jaw"], "scale")):
        for frame in (1, 17, 55):
            setattr(bone, path, (frame / 100, 0.5, 1))
            bone.keyframe_insert(path, frame=frame)
    owner.keyframe_insert('["mood"]', frame=9)
    old = action_of(owner)
    old["mine"] = "note"
    new = run().action
    changed = {KNEE, 'pose.bones["pelvis"].location'}
    pair = [[c for c in kept(action, owner)[1] if c[0] not in changed] for action in (old, new)]
    assert pair[0] == pair[1] and {'["mood"]'} < {c[0] for c in pair[1]}
    assert new["mine"] == "note"


@pytest.mark.parametrize("family", ["mpi", "meshcapade"])
@pytest.mark.parametrize("mode", ["QUATERNION", "XYZ", "ZYX", "AXIS_ANGLE"])
def test_any_rig_with_a_moving_root_bone(family, mode):
    rigs.reset()
    rooms.to_blender(rooms.random_room(1, rooms.sofa), bpy.context.scene)
    rig = rigs.make(family)
    for bone in rig.pose.bones:
        bone.rotation_mode = mode
    keyframes.write_motion(rig, rigs.take(FRAMES), "Take")
    root = rig.pose.bones["root"]
    path = keyframes.channels.rotation_channel(mode)[0]
    for frame, turn in ((1, 0.2), (50, 0.6)):
        root.location = (turn, 0.1, 2 * turn)
        setattr(root, path, (turn,) * 3 if path == "rotation_euler" else (1, turn, 0.2, 0.1))
        root.keyframe_insert("location", frame=frame)
        root.keyframe_insert(path, frame=frame)
    before = keyframes.read_motion(rig)
    moved = [c for c in kept(action_of(rig), rig)[1] if '"root"' in c[0]]
    new = run(frame_start=15, frame_end=45).action
    after = keyframes.read_motion(rig, new)
    assert [c for c in kept(new, rig)[1] if '"root"' in c[0]] == moved
    weights = rekeying.fade_weights(31, True, True, 30)
    wanted = before.root.copy()
    wanted[14:45, 1] += fakes.RAISED * weights
    np.testing.assert_allclose(after.root, wanted, atol=2e-5)
    joints = skeleton.forward_kinematics(after.root, after.rotations, after.rest_joints)[0]
    assert np.abs(rigs.world_joints(rig, 30) - joints[29, :22]).max() < 2e-5


def test_missing_curves_are_added(owner):
    slot = getattr(owner.animation_data, "action_slot", None)  # there are none before Blender 4.4
    writer = compat.CurveWriter(action_of(owner), owner, slot)
    for index in range(4):
        writer.remove(curve_of(owner, KNEE, index))
    before = keyframes.read_motion(owner)
    after = keyframes.read_motion(owner, run(frame_start=20, frame_end=50).action)
    assert np.abs(after.rotations[:19] - before.rotations[:19]).max() < 1e-5
    turned = rotation.multiply(rotation.conjugate(before.rotations[34]), after.rotations[34])
    assert rotation.to_axis_angle(turned[skeleton.INDEX["left_knee"]])[0] == pytest.approx(
        fakes.BENT, abs=1e-4
    )


# --------------------------------------------------------------------------------- errors


def broken(value, field="co"):
    def arrange(owner):
        key = curve_of(owner, KNEE, 2).keyframe_points[11]
        setattr(key, field, (12.0, value))

    return arrange


def no_action(owner):
    owner.animation_data.action = None


def no_bones(owner):
    owner.animation_data.action = None
    owner.keyframe_insert("location", frame=1)


def moving_object(owner):
    for frame in (1, 30):
        owner.location.x = frame
        owner.keyframe_insert("location", frame=frame)


def empty_scene(owner):
    for obj in list(bpy.context.scene.objects):
        if owner not in (obj, obj.parent):
            bpy.data.objects.remove(obj)


@pytest.mark.parametrize(
    ("arrange", "options", "reason"),
    [
        (broken(np.nan), {}, "'left_knee' in frame 12"),
        (broken(np.inf), {}, "'left_knee' in frame 12"),
        (broken(np.nan, "handle_left"), {}, "'left_knee' in frame 12"),
        (broken(np.nan), {"frame_start": 40, "frame_end": 50}, "'left_knee' in frame 12"),
        (no_action, {}, "has no Action"),
        (no_bones, {}, "animates no bone of 'Human'"),
        (moving_object, {}, "animates the object 'Human' itself"),
        (empty_scene, {}, "Nothing stands near"),
        (lambda owner: None, {"action_name": "Dance"}, "no Action 'Dance'"),
        (lambda owner: None, {"character": "Bob"}, "no object 'Bob'"),
        (
            lambda owner: None,
            {"frame_start": 100, "frame_end": 120},
            "this range; choose frames from 1 to 60",
        ),
        (lambda owner: None, {"frame_start": 30, "frame_end": 20}, "no frames in this range"),
    ],
)
def test_errors_are_one_sentence_and_change_nothing(owner, arrange, options, reason):
    arrange(owner)
    before = [kept(action, owner) for action in bpy.data.actions]
    active = action_of(owner)
    with pytest.raises(SampError, match=reason) as caught:
        run(**options)
    assert "\n" not in str(caught.value)
    assert str(before) == str([kept(action, owner) for action in bpy.data.actions])
    assert action_of(owner) == active


def test_a_failure_while_writing_leaves_nothing_behind(owner, monkeypatch):
    old = action_of(owner)
    before = kept(old, owner)

    def fail(*arguments):
        raise ZeroDivisionError

    monkeypatch.setattr(curve_keys.CurveKeys, "replace_in", fail)
    with pytest.raises(ZeroDivisionError):
        run()
    assert list(bpy.data.actions) == [old] and kept(old, owner) == before and action_of(owner) == old


def test_armature_without_a_mesh_is_reported():
    rigs.reset()
    rooms.to_blender(rooms.random_room(1, rooms.sofa), bpy.context.scene)
    rig = rigs.make("mpi", skeleton.default_rest_joints() * 1.1)
    keyframes.write_motion(rig, take())
    plan = refine_action.read(bpy.context)
    assert plan.remarks == ("'SMPLX' has no body surface; the default human was fitted to its bones.",)
    np.testing.assert_allclose(plan.body.joints, skeleton.default_rest_joints() * 1.1, atol=1e-6)
    assert plan.remarks[0] in refine_action.sentence(run())


def test_summary(owner):
    result = run()
    assert refine_action.sentence(result) == (
        "'Take refined': deepest penetration 4.0 to 0.5 cm, foot slide 5.0 to 1.0 cm/s, contact 90.0 to 100.0 %. "
        "It was a fake. The body is still 4 cm deep in the scene somewhere."
    )
    note = "The body is still 4 cm deep in the scene; move the furniture."
    said = replace(result, refined=replace(result.refined, notes=(note,)))
    assert refine_action.sentence(said).endswith(f"%. {note}")
    solved = replace(result, refined=replace(result.refined, unsolved=0.0, notes=(), before={}))
    assert refine_action.sentence(solved) == "'Take refined': refined."


# ------------------------------------------------------------------------------ the operator


def test_operator_equals_its_function(owner):
    old = action_of(owner)
    assert bpy.ops.samp.refine(use_range=True, frame_start=10, frame_end=50, strength=0.5) == {"FINISHED"}
    pressed = action_of(owner)
    called = run(action_name="Take", frame_start=10, frame_end=50, settings=Settings(strength=0.5)).action
    assert pressed.name == "Take refined" and called.name == "Take refined.001"
    assert kept(pressed, owner)[1:] == kept(called, owner)[1:]
    assert old.name == "Take"


def test_options_are_passed_to_the_optimiser(owner, monkeypatch):
    seen = []

    def listen(motion, surroundings, goal, body, settings, progress):
        seen.append(
            (len(motion), settings, goal is not None, len(surroundings.triangles) == len(surroundings.give))
        )
        return fakes.refine(motion, surroundings)

    monkeypatch.setattr(optimiser, "refine", listen)
    bpy.ops.samp.refine(foot=2.0, smooth=0.5)
    assert seen == [(FRAMES, Settings(foot=2.0, smooth=0.5), True, True)]
    known = bpy.ops.samp.refine.get_rna_type().properties
    for name, value in vars(Settings()).items():
        assert known[name].default == pytest.approx(value)
    assert set(vars(Settings())) == {*operator.WEIGHTS, "strength"}


def test_undo_is_one_step(owner):
    bpy.context.preferences.edit.use_global_undo = True
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.samp.refine("EXEC_DEFAULT", True)
    assert len(bpy.data.actions) == 2
    bpy.ops.ed.undo()
    assert [action.name for action in bpy.data.actions] == ["Take"]
    assert bpy.data.objects["Human"].animation_data.action.name == "Take"


def endless(motion, surroundings, goal, body, settings, progress):
    while True:
        progress("Windows", 0.25)
        time.sleep(0.01)


def wait_for(condition):
    deadline = time.time() + 60
    while not condition() and time.time() < deadline:
        time.sleep(0.02)
    assert condition()


def test_stopping_leaves_nothing_behind(owner):
    before = kept(action_of(owner), owner)
    run_ = refine_action.begin(bpy.context, refine=endless)
    wait_for(lambda: run_.stage == "Windows")
    run_.stop()
    assert run_.done
    with pytest.raises(Cancelled):
        run_.finish(bpy.context)
    assert len(bpy.data.actions) == 1 and kept(action_of(owner), owner) == before


def test_escape_cancels(owner, monkeypatch):
    monkeypatch.setattr(optimiser, "refine", endless)

    class Pressed(operator.ThreadOperator):
        bl_label = "Refine"
        reports = []

        def report(self, kind, text):
            self.reports.append((kind, text))

        def begin(self, context):
            return refine_action.begin(bpy.context)

    made, screen = Pressed(), Screen()
    made._begin(screen)
    tick, escape = SimpleNamespace(type="TIMER"), SimpleNamespace(type="ESC", value="PRESS")

    def shown():
        made.modal(screen, tick)
        return screen.status == "Refine: Windows 25 %   (Esc stops)"

    wait_for(shown)
    assert made.modal(screen, escape) == {"CANCELLED"}
    assert made.reports == [({"INFO"}, "Stopped; nothing was changed.")]
    assert (screen.timers, len(bpy.data.actions), made._run.done) == ([], 1, True)


def test_thread_makes_the_same_and_reports_a_deleted_action(owner):
    started = refine_action.begin(bpy.context)
    wait_for(lambda: started.done)
    result = started.finish(bpy.context)
    assert kept(result.action, owner)[1:] == kept(run(action_name="Take").action, owner)[1:]
    started = refine_action.begin(bpy.context, action_name="Take")
    wait_for(lambda: started.done)
    bpy.data.actions.remove(bpy.data.actions["Take"])
    with pytest.raises(SampError, match="was deleted"):
        started.finish(bpy.context)


# -------------------------------------------------------------------------------- soft seats


def click(*names):
    for thing in bpy.context.scene.objects:
        thing.select_set(thing.name in names)
    bpy.context.view_layer.objects.active = bpy.data.objects[names[-1]] if names else None


@pytest.mark.parametrize(
    ("selected", "softened"),
    [
        (("Sofa",), {"Sofa"}),
        (("Sofa", "Obstacle 1", "Human", "Human mesh"), {"Sofa", "Obstacle 1"}),
        (("Human",), None),
        ((), None),
    ],
)
def test_cushion_depth_of_selected_seats(owner, selected, softened):
    click(*selected)
    if softened is None:
        with pytest.raises(RuntimeError, match="No furniture is selected"):
            bpy.ops.samp.set_cushion()
        return
    assert bpy.ops.samp.set_cushion() == {"FINISHED"}
    names = [obj.name for obj in bpy.context.scene.objects if read_scene.CUSHION_KEY in obj]
    assert set(names) == softened
    plan = refine_action.read(bpy.context)
    scene = read_scene.read_scene(bpy.context, [owner])
    soft = np.isin(scene.object_ids, [scene.names.index(name) for name in softened])
    np.testing.assert_allclose(plan.surroundings.give, np.where(soft, 0.03, 0.0))


def test_soft_seat_undo_is_one_step(owner):
    bpy.context.preferences.edit.use_global_undo = True
    click("Sofa")
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.samp.set_cushion("EXEC_DEFAULT", True, depth=0.05)
    assert bpy.data.objects["Sofa"][read_scene.CUSHION_KEY] == pytest.approx(0.05)
    bpy.ops.ed.undo()
    assert read_scene.CUSHION_KEY not in bpy.data.objects["Sofa"]
