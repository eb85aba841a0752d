"""Sit Here, Lie Here, Walk Here and Measure Take equal their functions, at once and in a thread."""

from __future__ import annotations

import json
import time
from dataclasses import replace
from types import SimpleNamespace

import bpy
import fakes
import numpy as np
import pytest
import rooms
from samp_blender.operators.generate import SAMP_OT_generate
from samp_blender.samp_addon.blender import running_work, thread_run
from samp_blender.samp_addon.blender.actions import keyframes
from samp_blender.samp_addon.blender.character import character
from samp_blender.samp_addon.blender.scene import targets
from samp_blender.samp_addon.blender.takes import baking, loading, measure
from samp_blender.samp_addon.blender.thread_run import Cancelled, ThreadRun
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.methods.samp import networks
from samp_blender.samp_addon.methods.samp.networks import Networks
from samp_blender.samp_addon.pipeline import driver
from samp_blender.samp_addon.pipeline.job import Job
from samp_blender.samp_addon.refine import refinement
from screen import Screen

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture(autouse=True)
def _fake_networks(monkeypatch):
    monkeypatch.setattr(networks, "trained", lambda: fakes.NETWORKS)
    monkeypatch.setattr(refinement, "refine", fakes.refine)


@pytest.fixture
def start():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    made = rooms.to_blender(rooms.random_room(1, rooms.sofa), bpy.context.scene)
    bpy.context.view_layer.update()
    character.create_character(bpy.context, location=tuple(made[:3]), yaw=1.0)
    return made


def click(*names):
    for thing in bpy.context.selected_objects:
        thing.select_set(False)
    for name in names:
        bpy.data.objects[name].select_set(True)
    bpy.context.view_layer.objects.active = bpy.data.objects[names[-1]] if names else None


def curves(action, owner):
    take = keyframes.read_motion(owner, action)
    return np.concatenate([take.root.ravel(), take.rotations.ravel()])


@pytest.mark.parametrize(
    ("operator", "options", "job"),
    [
        ("sit_here", {"target": "Sofa", "seed": 4}, {"action": "sit", "target": "Sofa", "seed": 4}),
        (
            "sit_here",
            {"target": "Sofa", "refine": True},
            {"action": "sit", "target": "Sofa", "refine": True},
        ),
        (
            "sit_here",
            {"target": "Sofa", "location": (1.0, 2.0, 0.5)},
            {"action": "sit", "target": "Sofa", "point": (1.0, 2.0, 0.5)},
        ),
        ("walk_here", {"location": (-3, -3, 0)}, {"action": "walk", "to": (-3.0, -3.0, 0.0)}),
        (
            "walk_here",
            {"location": (-3, -3, 0), "run": True, "use_yaw": True, "yaw": 0.5},
            {"action": "run", "to": (-3.0, -3.0, 0.0, float(np.degrees(0.5)))},
        ),
    ],
)
def test_operators_equal_their_functions(start, operator, options, job):
    assert getattr(bpy.ops.samp, operator)(**options) == {"FINISHED"}
    owner = bpy.data.objects["Human"]
    pressed = owner.animation_data.action
    called = baking.run(bpy.context, Job(**job), tools=fakes.TOOLS)
    assert called.owner == owner
    np.testing.assert_allclose(curves(pressed, owner), curves(called.actions[0], owner), atol=1e-5)


def test_selected_furniture_is_the_target(start):
    click("Human", "Sofa")
    assert bpy.ops.samp.sit_here() == {"FINISHED"}
    assert bpy.data.objects["Human"].animation_data.action.name == "sit Sofa 0"


def test_custom_start(start):
    assert bpy.ops.samp.sit_here(target="Sofa", use_start=True, start=(3, 3, 0), start_yaw=0.0) == {
        "FINISHED"
    }
    bpy.context.scene.frame_set(1)
    owner = bpy.data.objects["Human"]
    pelvis = owner.matrix_world @ owner.pose.bones["pelvis"].head
    np.testing.assert_allclose(pelvis[:2], (3, 3), atol=0.1)


@pytest.mark.parametrize(
    ("operator", "options", "reason"),
    [
        ("sit_here", {"target": "Soffa"}, "There is no 'Soffa'"),
        ("sit_here", {}, "No furniture is selected"),
        ("lie_here", {"target": "Obstacle 1", "character": "Bob"}, "no object 'Bob'"),
        ("walk_here", {"location": (100, 0, 0)}, "goal"),
    ],
)
def test_errors_are_one_report(start, operator, options, reason):
    click("Human")
    with pytest.raises(RuntimeError, match=reason):
        getattr(bpy.ops.samp, operator)(**options)
    assert bpy.data.objects["Human"].animation_data is None


def test_undo_is_one_step(start):
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.samp.sit_here("EXEC_DEFAULT", True, target="Sofa", variants=2)
    assert len(bpy.data.actions) == 2
    bpy.ops.ed.undo()
    assert len(bpy.data.actions) == 0
    assert (
        bpy.data.objects["Human"].animation_data is None
        or not bpy.data.objects["Human"].animation_data.action
    )


def test_parts_select_the_whole_piece():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    made = {}
    for name, parent, size in (
        ("Room", None, 0),
        ("Sofa", "Room", 0),
        ("Seat", "Sofa", 2),
        ("Shelf", "Room", 1),
    ):
        data = None
        if size:
            data = bpy.data.meshes.new(name)
            data.from_pydata([(0, 0, 0), (size, 0, 0), (0, size, 1)], [], [(0, 1, 2)])
        made[name] = bpy.data.objects.new(name, data)
        made[name].parent = made.get(parent)
        scene.collection.objects.link(made[name])
    made["Shelf"].location.x = 5
    bpy.context.view_layer.update()
    for name, whole in (("Seat", "Sofa"), ("Sofa", "Sofa"), ("Shelf", "Shelf")):
        click(name)
        assert targets.clicked_target(bpy.context) == whole
    click()
    with pytest.raises(SampError, match="No furniture"):
        targets.clicked_target(bpy.context)


def wait_for(run):
    deadline = time.time() + 60
    while not run.done and time.time() < deadline:
        time.sleep(0.02)
    assert run.done


def test_thread_makes_the_same_take(start):
    job = Job(action="sit", target="Sofa", seed=4)
    run = baking.begin(bpy.context, job, fakes.TOOLS)
    wait_for(run)
    assert (run.stage, run.share) == ("Done", 1.0)
    result = run.finish(bpy.context)
    called = baking.run(bpy.context, job, tools=fakes.TOOLS)
    np.testing.assert_allclose(
        curves(result.actions[0], result.owner), curves(called.actions[0], result.owner), atol=1e-5
    )


def test_stopped_thread_leaves_nothing_behind(start):
    def endless(requests, progress):
        while True:
            progress(0.5)
            time.sleep(0.01)

    run = baking.begin(bpy.context, Job(action="sit", target="Sofa"), fakes.toolbox(endless))
    deadline = time.time() + 60
    while run.stage != "Moving" and time.time() < deadline:
        time.sleep(0.02)
    run.stop()
    assert run.done
    with pytest.raises(Cancelled):
        run.finish(bpy.context)
    assert len(bpy.data.actions) == 0


def test_thread_reports_failures_and_a_deleted_character(start):
    run = baking.begin(bpy.context, Job(action="sit", target="Sofa"), fakes.STUCK)
    wait_for(run)
    with pytest.raises(SampError, match="stuck"):
        run.finish(bpy.context)
    run = baking.begin(bpy.context, Job(action="sit", target="Sofa"), fakes.TOOLS)
    wait_for(run)
    bpy.data.objects.remove(bpy.data.objects["Human"])
    with pytest.raises(SampError, match="gone"):
        run.finish(bpy.context)


def pressed(job):
    """Stand-in for Blender's side of a modal operator."""
    from samp_blender.operators.job_operator import JobOperator

    class Pressed(JobOperator):
        bl_label = "Sit Here"
        reports = []

        def report(self, kind, text):
            self.reports.append((kind, text))

        def job(self, context):
            return job

        def begin(self, context):
            return baking.begin(bpy.context, job)

    made, screen = Pressed(), Screen()
    made.reports = []
    made._begin(screen)
    return made, screen


def test_escape_cancels_and_cleans_up(start, monkeypatch):
    def endless(requests, progress):
        while True:
            progress(0.25)
            time.sleep(0.01)

    monkeypatch.setattr(networks, "trained", lambda: Networks(fakes.sample_goals, endless))
    operator, screen = pressed(Job(action="sit", target="Sofa"))
    tick, escape, wheel = (
        SimpleNamespace(type=kind, value="PRESS") for kind in ("TIMER", "ESC", "WHEELUPMOUSE")
    )
    deadline = time.time() + 60
    while "Moving" not in (screen.status or "") and time.time() < deadline:
        assert operator.modal(screen, tick) == {"PASS_THROUGH"}
        time.sleep(0.02)
    work = running_work.current()
    assert (work.label, work.stage, work.share) == ("Sit Here", "Moving", 0.25)
    assert not bpy.ops.samp.walk_here.poll() and bpy.ops.samp.stop.poll()
    undo = SimpleNamespace(type="Z", ctrl=True, oskey=False)
    assert operator.modal(screen, undo) == {"RUNNING_MODAL"}
    assert screen.status == "Sit Here: Moving 25 %   (Esc stops)"
    assert operator.modal(screen, wheel) == {"PASS_THROUGH"}
    assert operator.modal(screen, escape) == {"CANCELLED"}
    assert (screen.timers, screen.status) == ([], None)
    assert operator.reports == [({"INFO"}, "Stopped; nothing was changed.")]
    assert len(bpy.data.actions) == 0
    assert running_work.current() is None and bpy.ops.samp.walk_here.poll()


@pytest.mark.parametrize("ends", ["done", "ESC", "failed"])
def test_networks_are_loaded_in_a_thread(start, monkeypatch, ends):
    """The scene is read after loading, and its errors are reported then."""
    monkeypatch.setattr(networks, "trained", lambda: fakes.NETWORKS)
    asked = []

    def begin(method):
        asked.append(method)
        return ThreadRun(lambda progress: time.sleep(0.3), thread_run.one_slice)

    monkeypatch.setattr(loading, "begin", begin)
    operator, screen = pressed(Job(action="sit", target="Nothing" if ends == "failed" else "Sofa"))
    assert operator._ghost is None and operator.modal(screen, SimpleNamespace(type="TIMER")) == {
        "PASS_THROUGH"
    }
    if ends == "ESC":
        assert operator.modal(screen, SimpleNamespace(type="ESC", value="PRESS")) == {"CANCELLED"}
    else:
        outcome, _ = written(operator, screen, lambda outcome: outcome in ({"FINISHED"}, {"CANCELLED"}))
        assert outcome == ({"CANCELLED"} if ends == "failed" else {"FINISHED"})
        assert ("Nothing" in operator.reports[0][1]) == (ends == "failed")
    assert asked == [operator.method_used(screen)]
    assert len(bpy.data.actions) == (ends == "done")
    assert (screen.timers, screen.status, running_work.current()) == ([], None, None)


@pytest.mark.parametrize("method", ["samp", "long_term"])
def test_the_networks_of_the_chosen_method_are_loaded(method):
    bpy.context.scene.samp.method = method
    assert SAMP_OT_generate.method_used(SimpleNamespace(), bpy.context) == method


MANY = Job(action="sit", target="Sofa", seed=4, variants=8)


def slow_measures(monkeypatch):
    """Let measuring take longer than a slice of writing."""
    real = baking.reporting.measured
    monkeypatch.setattr(baking.reporting, "measured", lambda *values: (time.sleep(0.1), real(*values))[1])


def written(operator, screen, until):
    """Send timer events until a condition; return the last outcome and the progress shown."""
    deadline, shown, outcome = time.time() + 60, [], None
    while not until(outcome) and time.time() < deadline:
        outcome = operator.modal(screen, SimpleNamespace(type="TIMER"))
        shown.append(screen.status)
        time.sleep(0.01)
    return outcome, shown


def test_takes_are_written_in_slices_between_redraws(start, monkeypatch):
    monkeypatch.setattr(networks, "trained", lambda: fakes.NETWORKS)
    slow_measures(monkeypatch)
    operator, screen = pressed(MANY)
    outcome, shown = written(operator, screen, lambda outcome: outcome == {"FINISHED"})
    assert outcome == {"FINISHED"} and operator.reports[0][0] == {"INFO"}
    assert len(bpy.data.actions) == 8 and (screen.timers, screen.status) == ([], None)
    assert len({status for status in shown if status and "Measuring" in status}) > 1
    assert running_work.current() is None


def writing(operator):
    """Return whether some takes are written."""
    return lambda outcome: len(bpy.data.actions) > 2 and operator._run.stage == "Measuring"


def test_escape_while_writing_removes_written_takes(start, monkeypatch):
    monkeypatch.setattr(networks, "trained", lambda: fakes.NETWORKS)
    slow_measures(monkeypatch)
    operator, screen = pressed(MANY)
    written(operator, screen, writing(operator))
    assert len(bpy.data.actions) > 2
    assert operator.modal(screen, SimpleNamespace(type="ESC", value="PRESS")) == {"CANCELLED"}
    assert len(bpy.data.actions) == 0 and running_work.current() is None


@pytest.mark.parametrize(
    ("value", "tools", "stops"),
    [
        ("PRESS", [], True),
        ("RELEASE", [], False),  # a move that Esc has just ended swallows the press only
        ("PRESS", ["TRANSFORM_OT_translate"], False),
        ("PRESS", ["SAMP_OT_sit_here"], True),
    ],
)
def test_escape_is_for_the_tool_that_is_used(start, monkeypatch, value, tools, stops):
    monkeypatch.setattr(networks, "trained", lambda: fakes.NETWORKS)
    operator, screen = pressed(Job(action="sit", target="Sofa"))
    screen.window = SimpleNamespace(modal_operators=[SimpleNamespace(bl_idname=name) for name in tools])
    outcome = operator.modal(screen, SimpleNamespace(type="ESC", value=value))
    assert outcome == ({"CANCELLED"} if stops else {"PASS_THROUGH"})
    if not stops:
        operator.cancel(screen)


def add_something(number):
    """What an artist adds meanwhile, of every kind that a job makes, too."""
    mesh, action = bpy.data.meshes.new(f"Mine {number}"), bpy.data.actions.new(f"My move {number}")
    thing = bpy.data.objects.new(f"Mine {number}", mesh)
    collection = bpy.data.collections.new(f"Mine {number}")
    bpy.context.scene.collection.children.link(collection)
    collection.objects.link(thing)
    mesh.materials.append(bpy.data.materials.new(f"Mine {number}"))
    thing.animation_data_create()
    bpy.data.armatures.new(f"Mine {number}")
    action.use_fake_user = True


@pytest.mark.parametrize("moment", range(30))
@pytest.mark.parametrize("new_character", [True, False])
def test_a_cancel_keeps_what_the_artist_made_meanwhile(start, monkeypatch, moment, new_character):
    if new_character:
        bpy.data.objects.remove(bpy.data.objects["Human"])
    plan = baking.read(bpy.context, replace(MANY, variants=3))
    made = driver.run(plan.work, tools=fakes.TOOLS)
    kinds = ("objects", "meshes", "actions", "armatures", "materials", "collections")
    before = {kind: set(getattr(bpy.data, kind).keys()) for kind in kinds}
    slices = baking.in_slices(bpy.context, plan, *made)
    own = 0
    for count, _ in enumerate(slices):
        if count % 3 == moment % 3:
            add_something(own)
            own += 1
        if count >= moment // 4:
            break
    slices.close()
    for kind in kinds:
        added = set(getattr(bpy.data, kind).keys()) - before[kind]
        assert len(added) == own and all(name.startswith(("Mine", "My move")) for name in added), kind
        assert before[kind] <= set(getattr(bpy.data, kind).keys())


def test_character_deleted_while_writing(start, monkeypatch):
    monkeypatch.setattr(networks, "trained", lambda: fakes.NETWORKS)
    slow_measures(monkeypatch)
    operator, screen = pressed(MANY)
    written(operator, screen, writing(operator))
    bpy.data.objects.remove(bpy.data.objects["Human"])
    outcome, _ = written(operator, screen, lambda outcome: outcome == {"CANCELLED"})
    assert operator.reports == [({"ERROR"}, "The character is gone since the work was begun; start again.")]
    assert len(bpy.data.actions) == 0 and running_work.current() is None


def test_cancel_button_stops_at_the_next_timer_event(start, monkeypatch):
    def endless(requests, progress):
        while True:
            progress(0.25)
            time.sleep(0.01)

    monkeypatch.setattr(networks, "trained", lambda: Networks(fakes.sample_goals, endless))
    operator, screen = pressed(Job(action="sit", target="Sofa"))
    assert bpy.ops.samp.stop() == {"FINISHED"}
    assert operator.modal(screen, SimpleNamespace(type="TIMER")) == {"CANCELLED"}
    assert running_work.current() is None and len(bpy.data.actions) == 0


def test_measure_equals_its_function(start):
    bpy.ops.samp.sit_here(target="Sofa")
    assert bpy.ops.samp.measure() == {"FINISHED"}
    written_ = json.loads(bpy.data.texts[measure.TEXT].as_string())
    name, numbers = measure.measure_take(bpy.context)
    assert written_ == json.loads(json.dumps({"action": name, "metrics": numbers}))
    assert numbers["success"] is True


def test_measure_of_a_moved_take(start):
    bpy.ops.samp.sit_here(target="Sofa")
    name, before = measure.measure_take(bpy.context)
    bpy.data.objects["Human"].location.x += 0.3
    bpy.context.view_layer.update()
    _, after = measure.measure_take(bpy.context)
    assert after["position_error_cm"] == pytest.approx(30, abs=4)
    assert (before["success"], after["success"]) == (True, False)


def test_measure_without_a_take_raises(start):
    with pytest.raises(RuntimeError, match="has no Action"):
        bpy.ops.samp.measure()
