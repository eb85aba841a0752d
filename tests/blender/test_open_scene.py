"""Scene files for the batch: every format is imported upright and in metres; invalid files raise."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from samp_blender.samp_addon.blender.scene import open_scene, read_scene
from samp_blender.samp_addon.errors import SampError


def save_blend(path):
    bpy.ops.wm.save_as_mainfile(filepath=path)


def save_gltf(path):
    bpy.ops.export_scene.gltf(filepath=path, export_format="GLB" if path.endswith("b") else "GLTF_SEPARATE")


def save_obj(path):
    bpy.ops.wm.obj_export(filepath=path, export_materials=False)


def save_fbx(path):
    bpy.ops.export_scene.fbx(filepath=path)


def save_usd(path):
    if "merge_parent_xform" not in bpy.ops.wm.usd_import.get_rna_type().properties:
        # Blender 4.2 names imported objects after their meshes.
        bpy.context.object.data.name = bpy.context.object.name
    bpy.ops.wm.usd_export(filepath=path)


@pytest.mark.parametrize(
    ("suffix", "save"),
    [
        (".blend", save_blend),
        (".glb", save_gltf),
        (".gltf", save_gltf),
        (".obj", save_obj),
        (".fbx", save_fbx),
        (".usd", save_usd),
        (".usdc", save_usd),
        (".GLB", save_gltf),
    ],
)
def test_every_format_is_imported_upright_and_in_metres(tmp_path, suffix, save):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.mesh.primitive_cube_add(size=1, location=(1, 2, 3), scale=(1, 2, 4))
    bpy.context.object.name = "Wardrobe"
    path = tmp_path / f"room{suffix}"
    save(str(path.with_suffix(suffix.lower())))
    path.with_suffix(suffix.lower()).rename(path)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    open_scene.open_scene(path)
    points = read_scene.read_target(bpy.context, "Wardrobe").triangles.reshape(-1, 3)
    np.testing.assert_allclose((points.min(0) + points.max(0)) / 2, (1, 3, -2), atol=1e-5)
    np.testing.assert_allclose(np.ptp(points, axis=0), (1, 4, 2), atol=1e-5)


def test_the_current_file_is_discarded(tmp_path):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.mesh.primitive_cube_add()
    save_obj(str(tmp_path / "room.obj"))
    bpy.context.object.name = "Before"
    open_scene.open_scene(tmp_path / "room.obj")
    assert "Before" not in bpy.data.objects and len(bpy.data.objects) == 1


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("room.max", b"x", "not a scene file"),
        ("room", b"x", "not a scene file"),
        ("missing.blend", None, "no file"),
        ("broken.blend", b"not a blend file", "cannot be read"),
        ("broken.glb", b"not a glb file", "cannot be read"),
        ("broken.gltf", b"{", "cannot be read"),
        ("broken.fbx", b"not an fbx file", "cannot be read"),
        ("broken.usd", b"not a usd file", "cannot be read"),
        ("empty.obj", b"", "cannot be read"),
    ],
)
def test_invalid_files_raise_one_sentence(tmp_path, name, content, words):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(SampError) as error:
        open_scene.open_scene(tmp_path / name)
    assert words in str(error.value) and name in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize(("units", "up"), [("cm", None), ("m", "Z"), ("mm", "Z")])
def test_units_and_up_axis_of_imported_files(tmp_path, units, up):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0.4, 1.2, 0.7))
    bpy.context.object.scale = (1, 2, 3)
    bpy.context.view_layer.update()
    upright = read_scene.read_scene(bpy.context).triangles
    path = str(tmp_path / "room.obj")
    axes = {"up_axis": "Z", "forward_axis": "Y"} if up == "Z" else {}
    bpy.ops.wm.obj_export(
        filepath=path, export_materials=False, global_scale=1 / open_scene.METRES[units], **axes
    )
    context = open_scene.open_for_job(tmp_path / "room.obj", units, up)
    found = read_scene.read_scene(context).triangles
    np.testing.assert_allclose(found.min((0, 1)), upright.min((0, 1)), atol=1e-4)
    np.testing.assert_allclose(found.max((0, 1)), upright.max((0, 1)), atol=1e-4)


@pytest.mark.parametrize("mode", ["EDIT", "SCULPT", "WEIGHT_PAINT"])
def test_files_saved_in_a_mode_are_opened_in_object_mode(tmp_path, mode):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.object.mode_set(mode=mode)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "room.blend"))
    context = open_scene.open_for_job(tmp_path / "room.blend")
    assert context.mode == "OBJECT" and len(read_scene.read_scene(context)) == 12
