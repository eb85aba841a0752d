"""The sidebar without a window: contents of its panels, and operators of its lists."""

from __future__ import annotations

import sys
import time
from types import SimpleNamespace

import bpy
import pytest
import samp_blender
import untrained
from samp_blender.operators.refine import SAMP_OT_refine
from samp_blender.operators.show_take import SAMP_OT_show_take
from samp_blender.samp_addon.blender import running_work
from samp_blender.samp_addon.blender.actions import keyframes, notes
from samp_blender.samp_addon.blender.character import character, measures
from samp_blender.samp_addon.blender.running_work import RunningWork
from samp_blender.samp_addon.blender.scene import read_scene
from samp_blender.samp_addon.blender.takes import export, judgement, loading, take_list
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.methods import registry
from samp_blender.samp_addon.ui import job_from_settings, lists, menu, panel, takes
from samp_blender.samp_addon.ui.parts import warm_up
from samp_blender.tests.support.blender import rigs

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture(autouse=True)
def _room():
    rigs.reset()
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.name = "Sofa"


def baked(owner):
    """Bake a take onto a character."""
    return keyframes.write_motion(owner, rigs.take(20), "take")


class Layout:
    """Stand-in for a layout: records names and checks that they exist."""

    def __init__(self):
        self.drawn = []

    def nested(self, **_):
        return self

    row = column = split = grid_flow = nested

    def operator(self, name, text="", **_):
        self.drawn.append(f"{name} {text}".strip())
        return _Options(getattr(bpy.ops.samp, name.split(".")[1]).get_rna_type().properties)

    def operator_menu_enum(self, name, choice, **_):
        options = getattr(bpy.ops.samp, name.split(".")[1]).get_rna_type().properties
        assert choice in options
        self.drawn.append(name)

    def prop(self, data, name, **_):
        assert name in data.bl_rna.properties or name.startswith("[")
        self.drawn.append(name)

    def prop_enum(self, data, name, value, **_):
        assert value in data.bl_rna.properties[name].enum_items
        self.drawn.append(f"{name} {value}")

    def template_list(self, kind, key, data, name, *_, **__):
        assert hasattr(bpy.types, kind)
        self.drawn.append(kind)

    def label(self, text="", **_):
        self.drawn.append(text)

    def progress(self, factor, text):
        self.drawn.append(f"{text} {factor}")

    def menu(self, name, **_):
        self.drawn.append(name)

    def separator(self, **_):
        pass


class _Options:
    """Properties of a drawn button: only those of the operator can be set."""

    def __init__(self, known):
        object.__setattr__(self, "known", known)

    def __setattr__(self, name, value):
        assert name in self.known, name


def drawn(kind):
    layout = Layout()
    kind.draw(SimpleNamespace(layout=layout), bpy.context)
    return layout.drawn


PANELS = (*panel.CLASSES, *panel.LATER, *panel.LAST, *takes.CLASSES, *lists.CLASSES, menu.SAMP_MT_menu)
ALL = tuple(kind for kind in PANELS if not issubclass(kind, bpy.types.UIList))


@pytest.mark.parametrize(
    ("action", "word"), [("sit", "Sit Here"), ("lie", "Lie Here"), ("walk", "Walk Here"), ("run", "Run Here")]
)
def test_button_label_follows_the_action(action, word):
    bpy.context.scene.samp.action = action
    assert f"samp.generate {word}" in drawn(panel.SAMP_PT_panel)


def test_the_first_line_says_what_to_do_next(monkeypatch):
    said = lambda: drawn(panel.SAMP_PT_panel)[0]
    settings, sofa = bpy.context.scene.samp, bpy.data.objects["Sofa"]
    assert said() == "Press Sit Here"
    sofa.select_set(False)
    bpy.context.view_layer.objects.active = None
    assert said() == "Select a chair, sofa or bench"
    settings.action = "lie"
    assert said() == "Select a bed or sofa"
    bpy.ops.mesh.primitive_plane_add(size=6)
    assert said() == "'Plane' is a floor: select a bed or sofa"
    settings.action = "walk"
    assert said() == "Press Walk Here"
    settings.action, settings.target = "sit", sofa
    assert said() == "Press Sit Here"
    settings.character = character.create_character(bpy.context)
    take = baked(settings.character)
    assert said() == "Press again for another take, or Refine this one"
    notes.write_measures(take, {"position_error_cm": 15.0})
    assert said().startswith("See the line under Takes")
    monkeypatch.setattr(running_work, "current", lambda: RunningWork("Sit Here", "generate"))
    assert said().startswith("Esc stops it")


def test_button_is_disabled_with_a_reason_without_a_seat():
    settings = bpy.context.scene.samp
    assert bpy.ops.samp.generate.poll()
    bpy.context.view_layer.objects.active = None
    bpy.data.objects["Sofa"].select_set(False)
    assert not bpy.ops.samp.generate.poll()
    with pytest.raises(RuntimeError, match="Select the furniture to sit on, or choose a target"):
        bpy.ops.samp.generate()
    settings.target = bpy.data.objects["Sofa"]
    assert bpy.ops.samp.generate.poll()
    settings.target, settings.action = None, "walk"
    assert bpy.ops.samp.generate.poll()


@pytest.mark.parametrize(
    ("operator", "kind", "button"),
    [
        ("generate", panel.SAMP_PT_panel, "samp.generate Sit Here"),
        ("lie_here", panel.SAMP_PT_panel, "samp.generate Sit Here"),
        ("refine", panel.SAMP_PT_refine, "samp.refine"),
        ("bake_chain", lists.SAMP_PT_chain, "samp.bake_chain"),
    ],
)
def test_progress_stands_in_the_place_of_the_button(monkeypatch, operator, kind, button):
    monkeypatch.setattr(running_work, "current", lambda: RunningWork("Pressed", operator, "Moving", 0.25))
    for other in (panel.SAMP_PT_panel, panel.SAMP_PT_refine, lists.SAMP_PT_chain):
        shown = drawn(other)
        assert ("Pressed: Moving 0.25" in shown) == ("samp.stop" in shown) == (other is kind)
        if other is kind:
            assert button not in shown


def test_refine_shows_its_options_and_the_cushion():
    assert drawn(panel.SAMP_PT_refine) == ["samp.refine", "strength", "use_range", "samp.set_cushion"]
    bpy.ops.samp.set_cushion()
    assert drawn(panel.SAMP_PT_refine)[-1] == panel.CUSHION == f'["{read_scene.CUSHION_KEY}"]'
    weights = drawn(panel.SAMP_PT_weights)
    assert set(weights) | {"strength"} == set(SAMP_OT_refine.__annotations__) - {
        "character", "action_name", "use_range", "frame_start", "frame_end",
    }  # fmt: skip


def test_measures_of_the_active_take():
    owner = character.create_character(bpy.context)
    action = baked(owner)
    notes.write_measures(action, {"position_error_cm": 1.0}, {"position_error_cm": 3.0})
    other = baked(owner)
    settings = bpy.context.scene.samp
    settings.character = owner
    assert settings.take_index == bpy.data.actions.find(other.name)
    settings.take_index = bpy.data.actions.find(action.name)
    assert "Position Error: 3.0 \N{RIGHTWARDS ARROW} 1.0 cm" in drawn(takes.SAMP_PT_takes)
    assert owner.animation_data.action == action


@pytest.mark.parametrize("kind", ALL, ids=lambda kind: kind.__name__)
@pytest.mark.parametrize("fill", ["empty", "full"])
def test_every_panel_draws(kind, fill):
    if fill == "full":
        settings = bpy.context.scene.samp
        bpy.ops.samp.edit_chain(change="ADD")
        settings.action = "walk"
        bpy.ops.samp.edit_chain(change="ADD")
        bpy.ops.samp.add_waypoint()
        settings.character = character.create_character(bpy.context)
        settings.take_index = bpy.data.actions.find(baked(settings.character).name)
    assert drawn(kind) or kind is panel.SAMP_PT_panel


# Buttons whose text depends on their options.
OWN_TEXT = ("samp.generate ", "samp.star_take ")


@pytest.mark.parametrize("kind", ALL, ids=lambda kind: kind.__name__)
def test_button_texts_equal_operator_labels(kind):
    buttons = [name for name in drawn(kind) if name.startswith("samp.")]
    assert [name for name in buttons if " " in name and not name.startswith(OWN_TEXT)] == []


def test_bone_table_is_drawn_if_filled():
    owner = rigs.make("meshcapade")
    bpy.context.view_layer.objects.active = owner
    assert drawn(lists.SAMP_PT_rig) == ["samp.carry_to_rig", "samp.guess_rig_map"]
    row = getattr(owner, lists.bone_table.TABLE).add()
    row.joint = "pelvis"
    assert drawn(lists.SAMP_PT_rig)[-1] == "SAMP_UL_rig_map"


def test_steps_are_edited():
    settings = bpy.context.scene.samp
    change = lambda what: bpy.ops.samp.edit_chain(change=what)
    assert not bpy.ops.samp.bake_chain.poll()
    change("ADD")
    settings.action = "walk"
    change("ADD")
    steps = lambda: [(step.action, step.target.name if step.target else "") for step in settings.steps]
    assert steps() == [("sit", "Sofa"), ("walk", "")] and bpy.ops.samp.bake_chain.poll()
    change("UP")
    assert steps() == [("walk", ""), ("sit", "Sofa")] and settings.step_index == 0
    change("DOWN")
    change("REMOVE")
    assert steps() == [("sit", "Sofa")]
    job = job_from_settings.job_of_steps(bpy.context)
    assert (job.action, job.target, job.then) == ("sit", "Sofa", ())


def test_takes_are_starred_pushed_down_and_deleted():
    owner = character.create_character(bpy.context)
    kept, other, third = (baked(owner) for _ in range(3))
    foreign = bpy.data.actions.new("mine")
    foreign.use_fake_user = True
    assert bpy.ops.samp.star_take(action_name=kept.name) == {"FINISHED"}
    assert bpy.ops.samp.push_down_take(action_name=third.name) == {"FINISHED"}
    assert owner.animation_data.action is None
    strip = owner.animation_data.nla_tracks[-1].strips[0]
    assert strip.action == third and strip.frame_start == third.frame_range[0]
    with pytest.raises(RuntimeError, match="delete the strip first"):
        bpy.ops.samp.delete_take(action_name=third.name)
    assert bpy.ops.samp.show_take(action_name=kept.name, fit=True) == {"FINISHED"}
    assert owner.animation_data.action == kept
    assert bpy.context.scene.frame_end == round(kept.frame_range[1])
    assert bpy.ops.samp.delete_take(unstarred=True) == {"FINISHED"}
    assert set(bpy.data.actions) == {kept, third, foreign}
    with pytest.raises(RuntimeError, match="no take 'mine'"):
        bpy.ops.samp.delete_take(action_name="mine")
    del other


@pytest.mark.parametrize("kind", ["NPZ", "FBX", "GLTF", "USD", "BVH"])
def test_export_keeps_the_selection(kind, tmp_path):
    owner = character.create_character(bpy.context)
    action = baked(owner)
    sofa = bpy.data.objects["Sofa"]
    owner.select_set(False)
    sofa.select_set(True)
    bpy.context.view_layer.objects.active = sofa
    before = (bpy.context.scene.frame_start, bpy.context.scene.frame_end, set(bpy.data.objects))
    assert bpy.ops.samp.export_take(filepath=str(tmp_path / "take"), kind=kind) == {"FINISHED"}
    [made] = tmp_path.iterdir()
    assert made.suffix == export.SUFFIXES[kind] and made.stat().st_size > 1000
    assert bpy.context.selected_objects == [sofa] and bpy.context.view_layer.objects.active == sofa
    assert (bpy.context.scene.frame_start, bpy.context.scene.frame_end, set(bpy.data.objects)) == before
    assert owner.animation_data.action == action
    action.name = "sit: Sofa/2"
    assert export.file_stem(bpy.context) == "sit--Sofa-2"


def test_exported_bvh_moves_as_the_take(tmp_path):
    owner = character.create_character(bpy.context)
    action = baked(owner)
    last = round(action.frame_range[1])
    bpy.context.scene.frame_set(last)
    expected = [tuple(owner.pose.bones[name].head) for name in ("pelvis", "left_foot", "head")]
    path = export.export_take(bpy.context, str(tmp_path / "take"), "BVH")
    bpy.ops.import_anim.bvh(filepath=str(path), axis_forward="Y", axis_up="Z", frame_start=last)
    read = bpy.context.view_layer.objects.active
    bpy.context.scene.frame_set(2 * last - round(action.frame_range[0]))
    for name, place in zip(("pelvis", "left_foot", "head"), expected, strict=True):
        assert tuple(read.pose.bones[name].head) == pytest.approx(place, abs=1e-3), name


def test_export_to_a_missing_folder_raises(tmp_path):
    baked(character.create_character(bpy.context))
    with pytest.raises(RuntimeError, match="choose another file|cannot be written"):
        bpy.ops.samp.export_take(filepath=str(tmp_path / "none" / "deep" / "take"), kind="BVH")


def test_overlays_are_cleared():
    bpy.ops.samp.add_waypoint()
    bpy.ops.samp.add_waypoint()
    assert bpy.ops.samp.clear_overlays(what="GOALS") == {"FINISHED"} and len(bpy.data.objects) == 3
    assert bpy.ops.samp.clear_overlays() == {"FINISHED"}
    assert [thing.name for thing in bpy.data.objects] == ["Sofa"]


def test_soft_seat_and_refine_are_greyed_with_a_reason():
    assert bpy.ops.samp.set_cushion.poll()
    with pytest.raises(RuntimeError, match="create a character first"):
        bpy.ops.samp.refine()
    owner = character.create_character(bpy.context)
    assert not bpy.ops.samp.set_cushion.poll()
    with pytest.raises(RuntimeError, match="select the seat first"):
        bpy.ops.samp.set_cushion()
    with pytest.raises(RuntimeError, match="has no Action"):
        bpy.ops.samp.refine()
    baked(owner)
    assert bpy.ops.samp.refine.poll()


@pytest.mark.parametrize(
    ("kind", "reason"), [("floor", "'Floor' is a floor"), ("lamp", "'Lamp' is not furniture")]
)
def test_floor_and_lamp_are_no_target(kind, reason):
    if kind == "floor":
        bpy.ops.mesh.primitive_plane_add(size=6)
        bpy.context.object.name = "Floor"
    else:
        bpy.ops.object.light_add()
        bpy.context.object.name = "Lamp"
    with pytest.raises(RuntimeError, match=f"{reason}; select the furniture to sit on"):
        bpy.ops.samp.generate()
    with pytest.raises(RuntimeError, match=f"{reason}; select furniture"):
        bpy.ops.samp.sit_here()
    bpy.data.objects["Sofa"].select_set(True)
    assert bpy.ops.samp.generate.poll()


def test_refine_takes_the_range_of_the_action():
    owner = character.create_character(bpy.context)
    keyframes.write_motion(owner, rigs.take(20), "take", 1001)
    options = panel.refine_options(bpy.context)
    options.use_range = True
    assert (options.frame_start, options.frame_end) == (1001, 1020)
    options.use_range = False


@pytest.mark.parametrize(
    ("measures", "warnings", "verdict", "reason"),
    [
        ({}, "", "UNKNOWN", "not been measured"),
        ({"penetration_max_cm": 1.0, "position_error_cm": 2.0}, "", "GOOD", "No fault"),
        ({"penetration_max_cm": 6.0}, "", "DOUBTFUL", "6 cm deep"),
        ({"penetration_max_cm": 6.0, "position_error_cm": 40.0}, "", "BAD", "ends 40 cm from its goal"),
        (
            {"penetration_max_cm": 6.0},
            "The body is 6 cm deep in the scene somewhere.",
            "DOUBTFUL",
            "The body is 6 cm deep in the scene somewhere.",
        ),
        ({"penetration_max_cm": 1.0}, "It squats in the air.\nIt glides.", "DOUBTFUL", "It glides."),
    ],
)
def test_verdict_on_a_take_is_its_tooltip(measures, warnings, verdict, reason):
    action = baked(character.create_character(bpy.context))
    notes.write_measures(action, measures)
    if warnings:
        action[judgement.WARNINGS_KEY] = warnings
    found, text = judgement.judge(action)
    assert found == verdict and text.count(reason) == 1
    options = SimpleNamespace(fit=False, explain=True, action_name=action.name)
    assert reason in SAMP_OT_show_take.description(bpy.context, options)
    options.explain, options.fit = False, True
    assert "frame range" in SAMP_OT_show_take.description(bpy.context, options)


def test_list_shows_the_takes_of_the_character():
    settings = bpy.context.scene.samp
    owner = character.create_character(bpy.context, name="Anna")
    first, second = baked(owner), baked(owner)
    other = character.create_character(bpy.context, name="Bert")
    third = baked(other)
    assert take_list.listed(settings) == [first, second, third]
    settings.character = owner
    assert take_list.listed(settings) == [first, second]
    assert owner.animation_data.action == second
    for direction, shown in (("NEXT", first), ("NEXT", second), ("PREVIOUS", first)):
        assert bpy.ops.samp.step_take(direction=direction) == {"FINISHED"}
        assert owner.animation_data.action == shown
    settings.only_character = False
    assert third in take_list.listed(settings)
    settings.only_character = True
    other.name = "Berta"  # whose takes would be lost from every list
    assert third in take_list.listed(settings)


@pytest.mark.parametrize(
    ("name", "short"),
    [
        ("sit Sofa 3", "sit Sofa 3"),
        ("sit SM_Sofa_Modern_01 12", "sit SM_Sof\N{HORIZONTAL ELLIPSIS} 12"),
        ("walkToTheDoorAndBack", "walkToTheDoor\N{HORIZONTAL ELLIPSIS}"),
    ],
)
def test_names_in_the_list_are_short(name, short):
    assert takes.short_name(name) == short and len(short) <= takes.LONGEST


def test_the_sliders_of_the_body():
    settings = bpy.context.scene.samp
    assert measures.values(settings) == {}
    settings.shape_height, settings.shape_gender = 1.8, 1.0
    found = measures.values(settings)
    assert found == pytest.approx({"height": 1.8, "muscle": 0.0, "age": 30.0, "gender": 1.0})
    settings.shape_use_weight, settings.shape_weight = True, 80.0
    assert measures.values(settings)["weight"] == pytest.approx(80)
    settings.action, settings.target = "sit", bpy.data.objects["Sofa"]
    assert job_from_settings.job(bpy.context).shape == measures.values(settings)
    settings.character = character.create_character(bpy.context)
    assert not job_from_settings.job(bpy.context).shape


@pytest.fixture
def _two_methods(monkeypatch):
    samp_blender.unregister()
    monkeypatch.setitem(registry.METHODS, "long_term", untrained.method())
    samp_blender.register()
    yield
    samp_blender.unregister()
    monkeypatch.undo()
    samp_blender.register()


@pytest.mark.usefixtures("_two_methods")
def test_steps_of_several_methods():
    settings, sofa = bpy.context.scene.samp, bpy.data.objects["Sofa"]
    for method, action in (("samp", "walk"), ("long_term", "sit")):
        bpy.ops.samp.edit_chain(change="ADD")
        step = settings.steps[-1]
        step.method, step.action, step.target = method, action, sofa
    job = job_from_settings.job_of_steps(bpy.context)
    assert [(step.method, step.action, step.target) for step in job.steps] == [
        ("samp", "walk", "Sofa"), ("long_term", "sit", "Sofa")
    ]  # fmt: skip
    assert dict(job.steps[1].settings)["pause"] == pytest.approx(0.7)


def test_networks_are_loaded_once_and_only_beside_a_window(monkeypatch):
    monkeypatch.setattr(warm_up, "_begun", {})
    assert warm_up.begin("samp") is None
    run = warm_up.begin("samp", in_window=True)
    assert run is warm_up.begin("samp", in_window=True)
    assert run.wait(120)
    assert {"torch", "samp_blender.samp_addon.methods.samp.rollout.generator"} <= set(sys.modules)


def test_a_button_that_is_pressed_while_networks_load_does_not_load_them_again(monkeypatch):
    """The weights are cached by the first of two calls only once it has returned."""
    inside, most = [], []

    def load(self):
        inside.append(1)
        most.append(len(inside))
        time.sleep(0.05)
        inside.pop()

    monkeypatch.setattr(type(registry.find("samp")), "load", load)
    runs = [loading.begin("samp") for _ in range(3)]
    assert all(run.wait(60) for run in runs) and most == [1, 1, 1]


def test_damaged_weights_do_not_stop_loading(monkeypatch):
    def damaged():
        raise SampError("The weights are damaged.")

    monkeypatch.setattr(type(registry.find("samp")), "load", lambda self: damaged())
    run = loading.begin("samp")
    assert run.wait(60)
    run.finish(bpy.context)
