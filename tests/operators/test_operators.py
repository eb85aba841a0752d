"""Operators of character, import and export equal their functions and undo in one step; labels and tooltips."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from samp_blender.operators import OPERATORS, operator_class
from samp_blender.samp_addon.blender.actions import keyframes
from samp_blender.samp_addon.blender.character import character
from samp_blender.samp_addon.blender.takes import amass_files
from samp_blender.samp_addon.body import amass, body_shape
from samp_blender.tests.support.blender import rigs

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture(autouse=True)
def _empty_file():
    rigs.reset()


def points(armature: bpy.types.Object) -> np.ndarray:
    mesh = armature.children[0].evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array([mesh.matrix_world @ vertex.co for vertex in mesh.data.vertices])


def test_create_character_equals_its_function():
    outcome = bpy.ops.samp.create_character(name="A", location=(1, 2, 3), yaw=0.5, female=1.0, tall=0.25)
    assert outcome == {"FINISHED"}
    made = bpy.context.view_layer.objects.active
    other = character.create_character(bpy.context, {"female": 1.0, "tall": 0.25}, (1, 2, 3), 0.5)
    assert np.abs(points(made) - points(other)).max() < 1e-6
    assert made.name == "A"


def test_create_character_with_a_height_and_a_weight():
    assert bpy.ops.samp.create_character(height=1.9, weight=95, gender=1) == {"FINISHED"}
    made = bpy.context.view_layer.objects.active
    shaped = [o for o in bpy.data.objects if o.parent == made and o.type == "MESH"][0]
    graph = bpy.context.evaluated_depsgraph_get()
    heights = [v.co.z for v in shaped.evaluated_get(graph).data.vertices]
    assert max(heights) - min(heights) == pytest.approx(1.9, abs=0.02)  # relaxed arms and feet on the floor
    assert body_shape.weight_of(character.body_of(made)) == pytest.approx(95, abs=1)
    with pytest.raises(RuntimeError, match="Weight is 40 kg; choose from"):
        bpy.ops.samp.create_character(height=1.9, weight=40)


def test_bake_and_export_equal_their_functions(tmp_path):
    owner = character.create_character(bpy.context)
    take = rigs.take(20)
    path = amass.write_amass(take, tmp_path / "wave.npz")
    assert bpy.ops.samp.bake(filepath=str(path), frame_start=5) == {"FINISHED"}
    baked = owner.animation_data.action
    assert baked.name == "wave" and tuple(baked.frame_range) == (5, 24)
    _, other = amass_files.import_take(bpy.context, str(path), frame_start=5)
    one, two = keyframes.read_motion(owner, baked), keyframes.read_motion(owner, other)
    assert np.array_equal(one.root, two.root) and np.array_equal(one.rotations, two.rotations)
    assert bpy.ops.samp.export_npz(filepath=str(tmp_path / "out.npz"), action_name="wave") == {"FINISHED"}
    amass_files.export_take(bpy.context, str(tmp_path / "same.npz"), action_name="wave")
    again, same = amass.read_amass(tmp_path / "out.npz"), amass.read_amass(tmp_path / "same.npz")
    assert np.array_equal(again.root, same.root) and np.array_equal(again.rotations, same.rotations)
    assert np.abs(again.root - take.root).max() < 1e-5


@pytest.mark.parametrize(
    ("call", "reason"),
    [
        (lambda: bpy.ops.samp.bake(filepath=""), "No file was named"),
        (lambda: bpy.ops.samp.bake(filepath="/nowhere/a.npz"), "There is no file"),
        (lambda: bpy.ops.samp.bake(filepath="/nowhere/a.npz", character="Nobody"), "no object 'Nobody'"),
        (lambda: bpy.ops.samp.export_npz(filepath=""), "No file was named"),
        (lambda: bpy.ops.samp.export_npz(filepath="a.npz"), "has no Action"),
        (lambda: bpy.ops.samp.export_npz(filepath="a.npz", action_name="Dance"), "no Action 'Dance'"),
    ],
)
def test_errors_are_one_sentence(call, reason):
    character.create_character(bpy.context)
    with pytest.raises(RuntimeError, match=reason) as caught:
        call()
    assert "Traceback" not in str(caught.value)


def test_poll_without_a_character():
    assert bpy.ops.samp.create_character.poll()
    assert not bpy.ops.samp.bake.poll() and not bpy.ops.samp.export_npz.poll()
    character.create_character(bpy.context)
    assert bpy.ops.samp.bake.poll() and bpy.ops.samp.export_npz.poll()
    bpy.ops.object.mode_set(mode="EDIT")
    assert not bpy.ops.samp.create_character.poll() and not bpy.ops.samp.bake.poll()


def test_undo_is_one_step():
    bpy.context.preferences.edit.use_global_undo = True
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.samp.create_character("EXEC_DEFAULT", True)
    assert len(bpy.context.scene.objects) == 3  # armature, body, and the marker of the start
    bpy.ops.ed.undo()
    assert len(bpy.context.scene.objects) == 0


SMALL_WORDS = {"to", "and", "of"}  # lower case in Blender's Title Case
UNLISTED = {"rna_type", "filter_glob"}


@pytest.mark.parametrize("name", OPERATORS)
def test_labels_are_in_title_case_and_tooltips_are_sentences_without_full_stop(name):
    cls = operator_class(name)
    assert isinstance(getattr(bpy.ops.samp, name).poll(), bool)  # in background, in an empty file
    texts = [(cls.bl_label, cls.__doc__)]
    for prop in getattr(bpy.ops.samp, name).get_rna_type().properties:
        if prop.identifier not in UNLISTED:
            texts.append((prop.name, prop.description))
            texts += [(item.name, item.description) for item in getattr(prop, "enum_items", ())]
    for label, tooltip in texts:
        words = label.split()
        assert words and all(w in SMALL_WORDS or not w[0].islower() or w == "glTF" for w in words), label
        assert tooltip and tooltip[0].isupper() and not tooltip.rstrip().endswith("."), (label, tooltip)


def test_humans_differ_in_their_looks_until_all_are_worn():
    from samp_blender.samp_addon.blender.character import materials

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    for _ in range(len(materials.LOOKS) + 1):
        assert bpy.ops.samp.create_character() == {"FINISHED"}
    bpy.ops.samp.create_character(look="Moss")
    humans = [obj for obj in bpy.data.objects if materials.LOOK_KEY in obj]
    worn = [obj[materials.LOOK_KEY] for obj in humans]
    assert sorted(worn) == sorted([*materials.LOOKS, next(iter(materials.LOOKS)), "Moss"])
    moss = bpy.data.materials["Human clothes Moss"]
    assert tuple(moss.diffuse_color[:3]) == pytest.approx(materials.LOOKS["Moss"]["clothes"])
    assert len([m for m in bpy.data.materials if m.name.startswith("Human clothes")]) == len(materials.LOOKS)
