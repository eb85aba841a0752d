"""Reading Blender's scene as triangles: contents of the scene, targets, and errors."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from samp_blender.samp_addon import frames
from samp_blender.samp_addon.blender import compat
from samp_blender.samp_addon.blender.scene import candidates, read_scene
from samp_blender.samp_addon.errors import SampError

UNIT_CUBE = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float) / 2
CUBE_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


@pytest.fixture(autouse=True)
def empty_file():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def add(name, location=(0, 0, 0), scale=(1, 1, 1), collection=None, parent=None, data=None):
    if data is None:
        data = bpy.data.meshes.new(name)
        data.from_pydata(UNIT_CUBE.tolist(), [], CUBE_FACES)
    obj = bpy.data.objects.new(name, None if data == "empty" else data)
    obj.location, obj.scale, obj.parent = location, scale, parent
    (collection or bpy.context.scene.collection).objects.link(obj)
    return obj


def new_collection(name, linked=True):
    collection = bpy.data.collections.new(name)
    if linked:
        bpy.context.scene.collection.children.link(collection)
    return collection


def extent(triangles):
    return np.ptp(triangles.reshape(-1, 3), axis=0)


def middle(triangles):
    points = triangles.reshape(-1, 3)
    return (points.min(0) + points.max(0)) / 2


def test_axes_of_the_network_frame():
    add("Box", location=(1, 2, 3), scale=(2, 4, 6))
    scene = read_scene.read_scene(bpy.context)
    assert scene.names == ("Box",) and len(scene) == 12
    np.testing.assert_allclose(middle(scene.triangles), (1, 3, -2), atol=1e-6)
    np.testing.assert_allclose(extent(scene.triangles), (2, 6, 4), atol=1e-6)


def hide_by_eye():
    add("X").hide_set(True)


def hide_in_viewport():
    add("X").hide_viewport = True


def hide_in_render():
    add("X").hide_render = True


def hide_collection_in_render():
    collection = new_collection("Props")
    add("X", collection=collection)
    collection.hide_render = True


def hide_collection_around_a_collection():
    outer, inner = new_collection("Outer"), new_collection("Inner", linked=False)
    outer.children.link(inner)
    add("X", collection=inner)
    outer.hide_render = True


def exclude_collection():
    add("X", collection=new_collection("Props"))
    bpy.context.view_layer.layer_collection.children["Props"].exclude = True


def drawn_by_the_addon():
    add("X")[candidates.OVERLAY_KEY] = True


def hidden_inside_a_collection_instance():
    library = new_collection("Library", linked=False)
    add("X", collection=library).hide_render = True
    instance = add("Instance", data="empty")
    instance.instance_type, instance.instance_collection = "COLLECTION", library


def collision_hull():
    add("UCX_X")


def fog():
    material = compat.new_node_material("Fog")
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    volume = nodes.new("ShaderNodeVolumePrincipled")
    links.new(volume.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Volume"])
    add("X").data.materials.append(material)


@pytest.mark.parametrize("arrange", [hide_by_eye, hide_in_viewport])
def test_what_only_the_viewport_hides_is_read(arrange):
    arrange()
    bpy.data.objects["X"].location = (4, 0, 0)
    assert read_scene.read_scene(bpy.context).names == ("X",)
    np.testing.assert_allclose(middle(read_scene.read_scene(bpy.context).triangles), (4, 0, 0), atol=1e-6)


def test_members_of_collection_instances_have_names_of_their_own():
    library = new_collection("Library", linked=False)
    add("Sofa", collection=library)
    add("Cushion", collection=library).parent = bpy.data.objects["Sofa"]
    add("Table", collection=library, location=(3, 0, 0))
    instance = add("Set", data="empty", location=(0, 7, 0))
    instance.instance_type, instance.instance_collection = "COLLECTION", library
    bpy.context.view_layer.update()
    assert set(read_scene.read_scene(bpy.context).names) == {"Set/Sofa", "Set/Cushion", "Set/Table"}
    for name in ("Set/Sofa", "Sofa"):
        found = read_scene.read_target(bpy.context, name)
        assert found.name == "Set/Sofa" and set(found.parts) == {"Set/Sofa", "Set/Cushion"}
    with pytest.raises(SampError, match="Set/Sofa"):
        read_scene.read_target(bpy.context, "Set/Sofaa")


@pytest.mark.parametrize(
    "arrange",
    [
        collision_hull,
        fog,
        hide_in_render,
        hide_collection_in_render,
        hide_collection_around_a_collection,
        exclude_collection,
        drawn_by_the_addon,
        hidden_inside_a_collection_instance,
    ],
)
def test_objects_not_rendered_are_left_out(arrange):
    add("Seen", location=(9, 0, 0))
    arrange()
    bpy.context.view_layer.update()
    assert read_scene.read_scene(bpy.context).names == ("Seen",)


def by_modifier():
    modifier = add("X").modifiers.new("Array", "ARRAY")
    modifier.count = 3
    modifier.relative_offset_displace = (1, 0, 0)
    return "X", 36, (3, 1, 1)


def by_parent_with_uneven_scale():
    parent = add("Parent", data="empty", scale=(2, 1, 0.5))
    add("X", parent=parent, location=(5, 0, 0)).rotation_euler = (0, 0, np.pi / 2)
    return "X", 12, (2, 0.5, 1)


def by_mirroring():
    add("X", scale=(-1, 1, 1))
    return "X", 12, (1, 1, 1)


def by_collection_instance():
    library = new_collection("Library", linked=False)
    add("Part", collection=library)
    add("Other", collection=library, location=(1, 0, 0))
    instance = add("X", data="empty", scale=(2, 1, 1))
    instance.instance_type, instance.instance_collection = "COLLECTION", library
    return ("X/Part", "X/Other"), 24, (4, 1, 1)


def by_nested_collection_instance():
    library, shelf = new_collection("Library", linked=False), new_collection("Shelf", linked=False)
    add("Part", collection=library)
    inner = add("Inner", data="empty", collection=shelf)
    inner.instance_type, inner.instance_collection = "COLLECTION", library
    outer = add("X", data="empty")
    outer.instance_type, outer.instance_collection = "COLLECTION", shelf
    return ("X/Part",), 12, (1, 1, 1)


def by_vertex_instancing():
    points = bpy.data.meshes.new("Points")
    points.from_pydata([(0, 0, 0), (0, 4, 0)], [], [])
    parent = add("X", data=points)
    parent.instance_type = "VERTS"
    add("Part", parent=parent)
    return "X", 24, (1, 1, 5)


def by_curve():
    curve = bpy.data.curves.new("X", "CURVE")
    spline = curve.splines.new("POLY")
    spline.points.add(1)
    spline.points[1].co = (2, 0, 0, 1)
    curve.extrude = 0.5
    add("X", data=curve)
    return "X", 2, None


def by_edit_mode():
    obj = add("X")
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")
    return "X", 12, (1, 1, 1)


@pytest.mark.parametrize(
    "arrange",
    [
        by_modifier,
        by_parent_with_uneven_scale,
        by_mirroring,
        by_collection_instance,
        by_nested_collection_instance,
        by_vertex_instancing,
        by_curve,
        by_edit_mode,
    ],
)
def test_visible_objects_are_read_as_evaluated(arrange):
    name, count, size = arrange()
    bpy.context.view_layer.update()
    scene = read_scene.read_scene(bpy.context)
    names = (name,) if isinstance(name, str) else name
    assert set(scene.names) <= {*names, "Part"} and len(scene.triangles_of(names)) == count
    if size:
        np.testing.assert_allclose(extent(scene.triangles_of(names)), size, atol=1e-5)


def test_mirrored_objects_keep_outward_normals():
    add("X", scale=(-1, 1, 1))
    triangles = read_scene.read_scene(bpy.context).triangles
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    assert (np.einsum("fi,fi->f", normals, triangles.mean(1)) > 0).all()


def test_the_character_is_left_out_with_its_meshes():
    armature = add("Rig", data=bpy.data.armatures.new("Rig"))
    add("Body").modifiers.new("Armature", "ARMATURE").object = armature
    add("Hat", parent=armature)
    add("Chair")
    assert read_scene.read_scene(bpy.context, exclude=[armature]).names == ("Chair",)
    assert set(read_scene.read_scene(bpy.context).names) == {"Body", "Hat", "Chair"}


def soft(obj, depth=0.03):
    obj[read_scene.CUSHION_KEY] = depth
    return obj


def its_own():
    soft(add("Sofa"))


def its_grandparents():
    add("Sofa", parent=add("Base", parent=soft(add("Furniture", data="empty")), data="empty"))


def a_part_of_what_it_shows():
    library = new_collection("Library", linked=False)
    soft(add("Seat", collection=library))
    add("Legs", collection=library)
    sofa = add("Sofa", data="empty")
    sofa.instance_type, sofa.instance_collection = "COLLECTION", library


def the_collection_that_it_shows():
    a_part_of_what_it_shows()
    del bpy.data.objects["Seat"][read_scene.CUSHION_KEY]
    bpy.data.objects.remove(bpy.data.objects["Legs"])
    soft(bpy.data.collections["Library"])


def harder_than_its_parent():
    soft(add("Sofa", parent=soft(add("Furniture", data="empty"), 0.1)))


def whole_metres():
    soft(add("Sofa"), 0)


@pytest.mark.parametrize(
    ("arrange", "depth"),
    [
        (its_own, 0.03),
        (its_grandparents, 0.03),
        (a_part_of_what_it_shows, 0.03),
        (the_collection_that_it_shows, 0.03),
        (harder_than_its_parent, 0.03),
        (whole_metres, 0.0),
        (lambda: add("Sofa"), 0.0),
    ],
)
def test_cushion_depth(arrange, depth):
    add("Lamp", location=(5, 0, 0))
    arrange()
    bpy.context.view_layer.update()
    scene = read_scene.read_scene(bpy.context)
    give = read_scene.cushion_depths(bpy.context, scene.names)[scene.object_ids]
    soft_one = next(name for name in ("Sofa", "Sofa/Seat") if name in scene.names)
    of_sofa = scene.object_ids == scene.names.index(soft_one)
    np.testing.assert_allclose(give, np.where(of_sofa, depth, 0.0))


@pytest.mark.parametrize("depth", ["soft", float("nan"), -0.1])
def test_invalid_cushion_depth_raises(depth):
    soft(add("Sofa"), depth)
    with pytest.raises(SampError, match="'Sofa' is not a valid length"):
        read_scene.cushion_depths(bpy.context, ["Sofa"])


def test_cushion_depths_of_an_empty_scene():
    assert read_scene.cushion_depths(bpy.context, []).shape == (0,)


def under_an_empty():
    root = add("Sofa", data="empty")
    seat = add("Seat", parent=root)
    add("Cushion", parent=seat, location=(0, 0, 1))


def in_a_collection():
    collection = new_collection("Sofa")
    add("Seat", collection=collection)
    add("Cushion", collection=collection, location=(0, 0, 1))


def in_collections_in_a_collection():
    collection, inner = new_collection("Sofa"), new_collection("Inner", linked=False)
    collection.children.link(inner)
    add("Seat", collection=collection)
    add("Cushion", collection=inner, location=(0, 0, 1))


def as_an_object_with_children():
    add("Cushion", parent=add("Sofa"), location=(0, 0, 1))


def as_a_collection_instance():
    library = new_collection("Library", linked=False)
    add("Seat", collection=library)
    add("Cushion", collection=library, location=(0, 0, 1))
    instance = add("Sofa", data="empty")
    instance.instance_type, instance.instance_collection = "COLLECTION", library


@pytest.mark.parametrize(
    "arrange",
    [
        under_an_empty,
        in_a_collection,
        in_collections_in_a_collection,
        as_an_object_with_children,
        as_a_collection_instance,
    ],
)
def test_furniture_of_several_objects(arrange):
    add("Lamp", location=(5, 0, 0))
    arrange()
    bpy.context.view_layer.update()
    target = read_scene.read_target(bpy.context, "Sofa")
    assert target.name == "Sofa" and len(target.triangles) == 24
    np.testing.assert_allclose(extent(target.triangles), (1, 2, 1), atol=1e-6)
    assert len(read_scene.read_scene(bpy.context).without(target.parts)) == 12


def bad_unknown():
    add("Sofa_Red")
    return "sofa red", "'Sofa_Red'"


def bad_empty_mesh():
    add("Sofa", data=bpy.data.meshes.new("Nothing"))
    return "Sofa", "no faces"


def bad_empty():
    add("Sofa", data="empty")
    return "Sofa", "no faces"


def bad_hidden():
    add("Sofa").hide_set(True)
    return "Sofa", "hidden"


def bad_not_rendered():
    add("Sofa").hide_render = True
    return "Sofa", "hidden"


def bad_nan():
    add("Sofa").data.vertices[3].co.x = float("nan")
    return "Sofa", "not numbers"


def bad_scaled_to_nothing():
    add("Sofa", scale=(0, 0, 1))
    return "Sofa", "no area"


@pytest.mark.parametrize(
    "arrange",
    [bad_unknown, bad_empty_mesh, bad_empty, bad_hidden, bad_not_rendered, bad_nan, bad_scaled_to_nothing],
)
def test_invalid_targets_raise(arrange):
    add("Lamp", location=(5, 0, 0))
    name, words = arrange()
    bpy.context.view_layer.update()
    with pytest.raises(SampError) as error:
        read_scene.read_target(bpy.context, name)
    assert words in str(error.value) and "Sofa" in str(error.value)
    assert "\n" not in str(error.value)


def test_nan_elsewhere_in_the_scene_names_its_object():
    add("Lamp").data.vertices[0].co.z = float("inf")
    with pytest.raises(SampError, match="Lamp"):
        read_scene.read_scene(bpy.context)


def test_flat_furniture_is_read():
    add("Rug", scale=(2, 1, 0))
    assert len(read_scene.read_target(bpy.context, "Rug").triangles) == 12


MESHES = {
    "triangles": ([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 1, 2), (0, 1, 3), (3, 2, 0)]),
    "quads": ([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2, 3)]),
    "concave": ([(0, 0, 0), (4, 0, 0), (1, 1, 0), (0, 4, 0), (-1, -1, 0)], [(0, 1, 2, 3), (4, 1, 0)]),
    "faces and a lone edge": ([(0, 0, 0), (1, 0, 0), (0, 1, 0), (5, 5, 5)], [(0, 1, 2)]),
}


@pytest.mark.parametrize("name", MESHES)
def test_triangles_are_those_of_blender(name):
    points, faces = MESHES[name]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [(0, 3)], faces)
    add("Thing", data=mesh)
    mesh.calc_loop_triangles()
    wanted = [[points[k] for k in triangle.vertices] for triangle in mesh.loop_triangles]
    found = frames.to_blender(read_scene.read_scene(bpy.context).triangles)
    np.testing.assert_allclose(found, wanted, atol=1e-6)


@pytest.mark.parametrize("points", [[], [(0, 0, 0), (1, 0, 0)]])
def test_meshes_without_faces_are_left_out(points):
    mesh = bpy.data.meshes.new("Bare")
    mesh.from_pydata(points, [(0, 1)] if points else [], [])
    add("Bare", data=mesh)
    add("Box")
    assert read_scene.read_scene(bpy.context).names == ("Box",)


def test_reading_does_not_change_the_scene():
    obj = add("Sofa")
    obj.modifiers.new("Subdivision", "SUBSURF")
    before = (len(bpy.data.meshes), len(bpy.data.objects), len(obj.data.vertices))
    read_scene.read_scene(bpy.context)
    assert before == (len(bpy.data.meshes), len(bpy.data.objects), len(obj.data.vertices))


def test_a_million_triangles():
    obj = add("Sofa")
    for name, levels in (("A", 6), ("B", 3)):
        modifier = obj.modifiers.new(name, "SUBSURF")
        modifier.levels, modifier.subdivision_type = levels, "SIMPLE"
    assert len(read_scene.read_target(bpy.context, "Sofa").triangles) > 1_000_000


def test_the_part_of_a_mesh_with_a_material():
    whole = add("Room")
    for name in ("Wall", "Sofa"):
        whole.data.materials.append(bpy.data.materials.new(name))
    face = whole.data.polygons[2]
    face.material_index = 1
    found = read_scene.read_target(bpy.context, "Room/Sofa")
    assert found.name == "Room" and len(found.triangles) == 12
    np.testing.assert_allclose(frames.to_blender(found.hint), face.center, atol=1e-6)
