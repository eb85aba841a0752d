"""The operators of sub-goals, their panel, and Bake: what a press does equals what the functions do, undone at once."""

from __future__ import annotations

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
import samp_blender
import untrained
from samp_blender.samp_addon import frames
from samp_blender.samp_addon.blender.actions import keyframes
from samp_blender.samp_addon.blender.character import armature, character
from samp_blender.samp_addon.blender.sub_goals import arrows, clicking, ghosts, placing, stored
from samp_blender.samp_addon.blender.takes import baking
from samp_blender.samp_addon.methods import registry
from samp_blender.samp_addon.pipeline.job import Job
from samp_blender.samp_addon.ui import job_from_settings, menu, panel, sub_goal_settings, sub_goals
from samp_blender.tests.operators.test_panel import Layout
from untrained import AIR, BED, FAR, FLOOR, SEAT

OPERATORS = (
    "add_sub_goal", "remove_sub_goal", "move_sub_goal", "clear_sub_goals", "sample_bodies", "pin_body",
    "use_current_pose",
)  # fmt: skip


@pytest.fixture(scope="module", autouse=True)
def _registered():
    patch = pytest.MonkeyPatch()
    patch.setitem(registry.METHODS, "long_term", untrained.method())
    samp_blender.register()
    yield
    samp_blender.unregister()
    patch.undo()


@pytest.fixture
def owner():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.context.scene.render.fps = 30
    bpy.context.preferences.edit.use_global_undo = True
    untrained.furnish(bpy.context.scene)
    made = character.create_character(bpy.context, location=(-0.5, 2.5, 0.0))
    bpy.context.scene.samp.method = "long_term"
    bpy.ops.ed.undo_push(message="room")
    return made


def press(name, **options):
    """Press a button: its operator with an undo step."""
    return getattr(bpy.ops.samp, name)("EXEC_DEFAULT", True, **options)


def found():
    """The sub-goals of the only character, after undo too."""
    return arrows.of(bpy.context, bpy.data.objects["Human"])


def state():
    """All that a sub-goal is, of each."""
    return [
        (arrow.name, [round(v, 4) for v in arrow.get(stored.POSE_KEY, ())], stored.is_pinned(arrow),
         [round(v, 5) for row in arrow.matrix_world for v in row], ghosts.find(arrow) is not None)
        for arrow in found()
    ]  # fmt: skip


def drawn(kind):
    layout = Layout()
    kind.draw(SimpleNamespace(layout=layout), bpy.context)
    return layout.drawn


@pytest.mark.parametrize(
    "name, options, function",
    [
        ("add_sub_goal", {"location": BED},
         lambda arrow: placing.add(bpy.context, arrows.owner_of(arrow), frames.to_network(BED))),
        ("add_sub_goal", {"location": FAR, "use_yaw": True, "yaw": 1.0},
         lambda arrow: placing.add(bpy.context, arrows.owner_of(arrow), frames.to_network(FAR), 1.0)),
        ("sample_bodies", {}, lambda arrow: placing.another(bpy.context, arrow)),
        ("pin_body", {}, stored.pin),
        ("use_current_pose", {}, lambda arrow: placing.use_pose(bpy.context, arrow)),
        ("use_current_pose", {"here": True}, lambda arrow: placing.use_pose(bpy.context, arrow, True)),
        ("move_sub_goal", {"direction": "UP"}, lambda arrow: arrows.move(bpy.context, arrow, -1)),
        ("remove_sub_goal", {}, lambda arrow: placing.remove(bpy.context, arrow)),
        ("clear_sub_goals", {}, lambda arrow: placing.clear(bpy.context, arrows.owner_of(arrow))),
    ],
)  # fmt: skip
def test_a_press_equals_the_function_and_is_undone_at_once(owner, name, options, function):
    for point in (FLOOR, SEAT):
        assert press("add_sub_goal", location=point) == {"FINISHED"}
    before = state()
    assert press(name, **options) == {"FINISHED"}
    pressed = state()
    assert pressed != before
    bpy.ops.ed.undo()
    assert state() == before
    function(found()[-1])
    assert state() == pressed


def test_add_at_the_cursor(owner):
    bpy.context.scene.cursor.location = SEAT
    assert press("add_sub_goal") == {"FINISHED"}
    (arrow,) = found()
    np.testing.assert_allclose(arrow.matrix_world.translation, SEAT, atol=1e-6)
    assert bpy.context.view_layer.objects.active == arrow and arrow.select_get()
    bpy.context.scene.cursor.location = AIR
    with pytest.raises(RuntimeError, match="is in the air; put it onto"):
        press("add_sub_goal")
    assert found() == [arrow]


def test_add_where_one_clicks(owner, monkeypatch):
    """A click beside all surfaces waits for another one, Esc stops."""
    places = iter([None, SEAT])
    monkeypatch.setattr(clicking, "surface_under", lambda context, x, y: next(places))
    from samp_blender.operators.add_sub_goal import SAMP_OT_add_sub_goal as kind

    ended, added = [], []
    made = SimpleNamespace(
        location=None, cancel=ended.append, execute=lambda c: added.append(c) or {"FINISHED"}
    )
    click = SimpleNamespace(type="LEFTMOUSE", value="PRESS", mouse_x=1, mouse_y=2)
    assert kind.modal(made, bpy.context, click) == {"RUNNING_MODAL"} and not added
    assert kind.modal(made, bpy.context, SimpleNamespace(type="MOUSEMOVE", value="")) == {"PASS_THROUGH"}
    assert kind.modal(made, bpy.context, click) == {"FINISHED"} and made.location == SEAT
    assert kind.modal(made, bpy.context, SimpleNamespace(type="ESC", value="PRESS")) == {"CANCELLED"}
    assert len(ended) == 2


def test_save_and_reload_keep_everything_and_bake(owner, tmp_path):
    for point in (FLOOR, SEAT):
        press("add_sub_goal", location=point)
    press("pin_body")
    before, path = state(), tmp_path / "blocked.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))
    assert state() == before and len(before) == 2
    settings = bpy.context.scene.samp
    settings.hold = 0.5
    assert job_from_settings.button_label(bpy.context) == "Bake"
    assert bpy.ops.samp.generate() == {"FINISHED"}
    action = bpy.data.objects["Human"].animation_data.action
    assert state() == before
    settings.method = "samp"
    assert bpy.ops.samp.bake(method="long_term") == {"FINISHED"} and settings.method == "samp"
    other = bpy.data.objects["Human"].animation_data.action
    again = baking.run(
        bpy.context,
        Job(
            action="",
            method="long_term",
            character="Human",
            hold=0.5,
            settings={"pause": settings.long_term_pause},
        ),
    )
    owner = bpy.data.objects["Human"]
    takes = [keyframes.read_motion(owner, made) for made in (action, other, again.actions[0])]
    np.testing.assert_allclose(takes[0].root, takes[2].root, atol=1e-6)
    np.testing.assert_allclose(takes[0].rotations, takes[2].rotations, atol=1e-6)
    assert other not in (action, again.actions[0])  # by the next seed


def test_continue_from_a_pose_to_a_single_sub_goal(owner):
    """The character's own pose is the start; the way to the sub-goal is walked."""
    press("add_sub_goal", location=FLOOR)
    settings = bpy.context.scene.samp
    settings.start_from, settings.hold = "POSE", 0.5
    owner.pose.bones["left_elbow"].rotation_quaternion = (0.8, 0.0, 0.6, 0.0)
    bpy.context.view_layer.update()
    pose = armature.posed(owner)
    assert bpy.ops.samp.generate() == {"FINISHED"}
    take = keyframes.read_motion(owner, owner.animation_data.action)
    np.testing.assert_allclose(take.root[0], pose.root[0], atol=1e-3)
    np.testing.assert_allclose(
        np.abs((take.rotations[0, :22] * pose.rotations[0, :22]).sum(-1)), 1, atol=1e-3
    )
    assert np.linalg.norm(np.diff(take.root, axis=0), axis=-1).max() < 0.15
    np.testing.assert_allclose(take.root[-1], stored.body(found()[0]).root[0], atol=0.1)


def test_without_sub_goals_the_target_counts(owner):
    settings = bpy.context.scene.samp
    settings.target = bpy.data.objects["Seat"]
    job = job_from_settings.job(bpy.context)
    assert (job.action, job.target, job.method) == ("sit", "Seat", "long_term")
    assert job_from_settings.button_label(bpy.context) == "Sit Here" and "target" in drawn(
        panel.SAMP_PT_panel
    )
    press("add_sub_goal", location=FLOOR)
    assert not bpy.ops.samp.generate.poll()
    with pytest.raises(RuntimeError, match="There is only one sub-goal; add another one"):
        bpy.ops.samp.generate()
    press("add_sub_goal", location=SEAT)
    job = job_from_settings.job(bpy.context)
    assert (job.action, job.target, job.character) == ("", "", "Human")
    assert "target" not in drawn(panel.SAMP_PT_panel)
    settings.method = "samp"
    assert job_from_settings.job(bpy.context).target == "Seat"


def test_the_panel_is_there_only_with_the_method(owner, monkeypatch):
    settings = bpy.context.scene.samp
    assert sub_goals.SAMP_PT_sub_goals.poll(bpy.context)
    assert drawn(sub_goals.SAMP_PT_sub_goals) == ["samp.add_sub_goal", "samp.add_sub_goal"]
    press("add_sub_goal", location=FLOOR)
    names = drawn(sub_goals.SAMP_PT_sub_goals)
    assert "SAMP_UL_sub_goals" in names and {f"samp.{name}" for name in OPERATORS} <= set(names)
    assert "samp.add_sub_goal" in drawn(menu.SAMP_MT_menu)
    settings.method = "samp"
    assert not sub_goals.SAMP_PT_sub_goals.poll(bpy.context)
    monkeypatch.delitem(registry.METHODS, "long_term")
    assert "samp.add_sub_goal" not in drawn(menu.SAMP_MT_menu)
    with pytest.raises(RuntimeError, match="The networks of Long-term are not installed"):
        press("add_sub_goal")


def test_the_list_shows_the_order_and_a_click_selects(owner):
    for point in (FLOOR, SEAT, FAR):
        press("add_sub_goal", location=point)
    first, _, third = found()
    press("move_sub_goal", sub_goal=third.name, direction="UP")
    home = arrows.collection(bpy.context.scene)
    flags, places = sub_goals.filtered(bpy.context, home.objects, "", 1)
    assert sorted(places) == list(range(6)) and sum(flags) == 3
    shown = sorted(
        (place, obj.name) for obj, flag, place in zip(home.objects, flags, places, strict=True) if flag
    )
    assert [name for _, name in shown] == [arrow.name for arrow in found()]
    settings = bpy.context.scene.samp
    settings.sub_goal_index = home.objects.find(first.name)
    assert sub_goal_settings.current(bpy.context) == first and settings.sub_goal_index == home.objects.find(
        first.name
    )
    assert bpy.context.view_layer.objects.active == first
    # Also where the character is active, as in Pose Mode.
    bpy.context.view_layer.objects.active = owner
    bpy.ops.object.mode_set(mode="POSE")
    settings.sub_goal_index = home.objects.find(third.name)
    assert sub_goal_settings.current(bpy.context) == third and bpy.context.mode == "POSE"
    assert press("use_current_pose") == {"FINISHED"} and stored.is_pinned(third)


@pytest.mark.parametrize(
    "name, prepare, reason",
    [
        ("sample_bodies", lambda: press("clear_sub_goals"), "There is no sub-goal; add one first"),
        ("sample_bodies", lambda: press("pin_body"), "is pinned; unpin it first"),
        ("move_sub_goal", lambda: None, "There is only one sub-goal"),
        (
            "use_current_pose",
            lambda: bpy.data.objects.remove(bpy.data.objects["Human"]),
            "no sub-goal|was deleted",
        ),
    ],
)
def test_greyed_buttons_say_why(owner, name, prepare, reason):
    press("add_sub_goal", location=FLOOR)
    prepare()
    assert not getattr(bpy.ops.samp, name).poll()
    with pytest.raises(RuntimeError, match=reason):
        press(name)


def test_a_problem_is_shown_in_the_panel(owner):
    press("add_sub_goal", location=FLOOR)
    (arrow,) = found()
    arrow.location = AIR
    placing.update(bpy.context, owner)
    assert "'Sub-goal 1 of Human' is in the air" in drawn(sub_goals.SAMP_PT_sub_goals)
