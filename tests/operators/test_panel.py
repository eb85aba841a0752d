"""The sidebar without a window: contents of its panels, and operators of its lists."""

from __future__ import annotations

from types import SimpleNamespace

import bpy
import pytest
import samp_blender
from samp_blender.operators.refine import SAMP_OT_refine
from samp_blender.samp_addon.blender import running_work
from samp_blender.samp_addon.blender.actions import keyframes, notes
from samp_blender.samp_addon.blender.character import character
from samp_blender.samp_addon.blender.running_work import RunningWork
from samp_blender.samp_addon.blender.scene import read_scene
from samp_blender.samp_addon.blender.takes import export
from samp_blender.samp_addon.ui import job_from_settings, lists, menu, panel
from samp_blender.tests.support.blender import rigs


@pytest.fixture(scope="module", autouse=True)
def _registered():
    samp_blender.register()
    yield
    samp_blender.unregister()


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

    row = column = nested

    def operator(self, name, text="", **_):
        self.drawn.append(f"{name} {text}".strip())
        return _Options(getattr(bpy.ops.samp, name.split(".")[1]).get_rna_type().properties)

    def prop(self, data, name, **_):
        assert name in data.bl_rna.properties or name.startswith("[")
        self.drawn.append(name)

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


ALL = (*panel.CLASSES, *panel.LATER, *panel.LAST, lists.SAMP_PT_takes, *lists.LATER, menu.SAMP_MT_menu)


@pytest.mark.parametrize(
    ("action", "word"), [("sit", "Sit Here"), ("lie", "Lie Here"), ("walk", "Walk Here"), ("run", "Run Here")]
)
def test_button_label_follows_the_action(action, word):
    bpy.context.scene.samp.action = action
    assert f"samp.generate {word}" in drawn(panel.SAMP_PT_panel)


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


def test_progress_and_cancel_button_while_work_is_running(monkeypatch):
    work = RunningWork("Generate Takes", "Moving", 0.25)
    monkeypatch.setattr(running_work, "current", lambda: work)
    shown = drawn(panel.SAMP_PT_panel)
    assert (
        shown[-2:] == ["Generate Takes: Moving 0.25", "samp.stop"] and "samp.generate Sit Here" not in shown
    )


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
    assert "Position Error: 3.0 \N{RIGHTWARDS ARROW} 1.0 cm" in drawn(lists.SAMP_PT_takes)
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
OWN_TEXT = ("samp.generate ", "samp.export_take ", "samp.star_take ")


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
