"""Save to Asset Library: what is in the new file, and that the open one stays as it is."""

from __future__ import annotations

import bpy
import fakes
import fingerprint
import numpy as np
import pytest
import sofa_room
from samp_blender.operators import save_asset
from samp_blender.samp_addon.blender.actions import notes
from samp_blender.samp_addon.blender.assets import catalogues, saving
from samp_blender.samp_addon.methods.samp import networks

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def owner(monkeypatch):
    monkeypatch.setattr(networks, "trained", lambda: fakes.NETWORKS)
    made = sofa_room.build()
    assert bpy.ops.samp.sit_here(target="Sofa", seed=3, hold=1.0) == {"FINISHED"}
    return made


def appended(path, kind):
    """Open an empty file and append the assets of another one."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(str(path), assets_only=True) as (found, wanted):
        setattr(wanted, kind, list(getattr(found, kind)))
    return getattr(wanted, kind)


@pytest.mark.parametrize("what", ["TAKE", "CHARACTER"])
def test_the_asset_has_a_catalogue_tags_and_a_picture_and_the_file_stays(owner, tmp_path, what):
    before = fingerprint.taken()
    take = owner.animation_data.action.name
    assert bpy.ops.samp.save_asset(what=what, directory=str(tmp_path)) == {"FINISHED"}
    assert fingerprint.differences(before, fingerprint.taken(), additions=False) == []
    (path,) = tmp_path.glob("*.blend")
    assert path.stem == (take if what == "TAKE" else "Human")
    (made,) = appended(path, "actions" if what == "TAKE" else "objects")
    assert made.name.startswith(path.stem)
    data = made.asset_data
    tags = {tag.name for tag in data.tags}
    assert tags == ({"SAMP", "sit", "Sofa"} if what == "TAKE" else {"SAMP", "Blue"})
    catalogue = saving.TAKES if what == "TAKE" else saving.CHARACTERS
    lines = (tmp_path / catalogues.FILE).read_text().splitlines()
    assert f"{data.catalog_id}:{catalogue}:{catalogue.replace('/', '-')}" in lines
    pixels = np.array(made.preview.image_pixels_float).reshape(*made.preview.image_size, 4)
    covered = pixels[..., 3] > 0.5
    assert 0.05 < covered.mean() < 0.8 and len(np.unique(pixels[covered].round(2), axis=0)) > 20


def test_the_appended_take_plays_on_another_character(owner, tmp_path):
    take = owner.animation_data.action
    last = int(take.frame_range[1])
    bpy.context.scene.frame_set(last)
    seated = np.array(owner.pose.bones["pelvis"].matrix)
    path = saving.save_take(bpy.context, owner, take, tmp_path)
    appended(path, "actions")
    (made,) = bpy.data.actions
    assert notes.is_take(made)
    bpy.ops.samp.create_character(name="Other")
    assert bpy.ops.samp.show_take(action_name=made.name) == {"FINISHED"}
    bpy.context.scene.frame_set(last)
    np.testing.assert_allclose(bpy.data.objects["Other"].pose.bones["pelvis"].matrix, seated, atol=1e-5)


def test_the_appended_character_stands_at_the_origin_and_can_be_used(owner, tmp_path):
    owner_yaw = owner.rotation_euler.z
    path = saving.save_character(owner, tmp_path)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(str(path), assets_only=True) as (found, _):
        (name,) = found.objects
    bpy.ops.wm.append(directory=f"{path}/Object/", filename=name)
    mesh = bpy.data.objects[name]
    assert not bpy.data.actions and {obj.type for obj in bpy.context.scene.objects} == {"ARMATURE", "MESH"}
    other = bpy.data.objects["Human"]
    assert mesh.parent == other and mesh.modifiers[0].object == other
    assert owner_yaw != 0 and tuple(other.rotation_euler) == (0, 0, 0)
    assert tuple(other.location) == (0, 0, 0) and saving.start.START_KEY not in other
    bpy.ops.mesh.primitive_plane_add(size=8)
    assert bpy.ops.samp.walk_here(location=(1, 1, 0), hold=0.0) == {"FINISHED"}


@pytest.mark.parametrize("twin", [False, True])
def test_a_linked_take_is_saved_under_its_name(owner, tmp_path, twin):
    """Names of linked data-blocks cannot be changed. twin: whether a local Action has the same name."""
    name = owner.animation_data.action.name
    elsewhere = tmp_path / "elsewhere.blend"
    bpy.data.libraries.write(str(elsewhere), {owner.animation_data.action})
    with bpy.data.libraries.load(str(elsewhere), link=True) as (_, wanted):
        wanted.actions = [name]
    (linked,) = wanted.actions
    if not twin:
        bpy.data.actions[name, None].name = "Another"
    before = sorted((action.name, action.library is None) for action in bpy.data.actions)
    folder = tmp_path / "library"
    folder.mkdir()
    path = saving.save_take(bpy.context, owner, linked, folder)
    assert path.stem == name and linked.name == name
    assert sorted((action.name, action.library is None) for action in bpy.data.actions) == before
    (made,) = appended(path, "actions")
    assert made.name == name


def test_files_are_never_overwritten_and_catalogues_are_kept(owner, tmp_path):
    (tmp_path / catalogues.FILE).write_text("VERSION 1\n\nabc:Props:Props\n1-2:SAMP/Takes:mine")
    take = owner.animation_data.action
    first, second = (saving.save_take(bpy.context, owner, take, tmp_path) for _ in range(2))
    assert first != second and second.stem.endswith("(2)")
    assert "abc:Props:Props" in (tmp_path / catalogues.FILE).read_text()
    assert catalogues.ensure(tmp_path, "SAMP/Takes") == "1-2"
    assert catalogues.ensure(tmp_path, "SAMP/Characters") == catalogues.ensure(tmp_path, "SAMP/Characters")


@pytest.mark.parametrize(
    ("directory", "message"), [("", "There is no asset library"), ("/nowhere/at/all", "There is no folder")]
)
def test_why_not(owner, directory, message, monkeypatch):
    monkeypatch.setattr(save_asset, "_first_library", lambda context: "")
    before = fingerprint.taken()
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.samp.save_asset(directory=directory)
    assert fingerprint.differences(before, fingerprint.taken(), additions=False) == []


def test_the_folder_of_the_preferences_is_made_as_blender_does(owner, tmp_path, monkeypatch):
    monkeypatch.setattr(save_asset, "_first_library", lambda context: str(tmp_path / "Assets"))
    assert bpy.ops.samp.save_asset() == {"FINISHED"}
    assert len(list((tmp_path / "Assets").glob("*.blend"))) == 1


def test_a_character_of_several_meshes_is_a_collection(owner, tmp_path):
    hat = bpy.data.objects.new("Hat", bpy.data.meshes.new("Hat"))
    bpy.context.scene.collection.objects.link(hat)
    hat.parent = owner
    path = saving.save_character(owner, tmp_path)
    (made,) = appended(path, "collections")
    assert sorted(obj.name for obj in made.objects if obj.type == "MESH")[0] == "Hat"
    assert {obj.parent for obj in made.objects} == {None, bpy.data.objects["Human"]}


def test_a_character_is_not_saved_with_its_control_rig(owner, tmp_path):
    bpy.ops.samp.add_control_rig()
    with pytest.raises(RuntimeError, match="has a control rig; remove it"):
        bpy.ops.samp.save_asset(what="CHARACTER", directory=str(tmp_path))
    assert list(tmp_path.iterdir()) == []
