"""Previews of voxels, navmesh and path: operators equal their functions and do not change the artist's data."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from samp_blender.samp_addon import frames
from samp_blender.samp_addon.blender.character import character
from samp_blender.samp_addon.blender.overlays import drawing, previews, start_marker, waypoints
from samp_blender.samp_addon.blender.scene import read_scene
from samp_blender.samp_addon.errors import PathError, SampError
from samp_blender.samp_addon.scene.navmesh.navmesh import Agent
from samp_blender.tests.support import layouts
from samp_blender.tests.support.blender import rigs

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture(autouse=True)
def _room():
    rigs.reset()
    add("Floor", layouts.floor(8, 8))
    add("Walls", layouts.walls(8))
    add("Sofa", layouts.sofa((1.5, 1.0), 2.0))
    add("Table", layouts.table((-1.0, -0.5)))


def add(name, triangles):
    """Add a mesh object of triangles in the network frame."""
    mesh = bpy.data.meshes.new(name)
    points = frames.to_blender(triangles).reshape(-1, 3)
    mesh.from_pydata(points.tolist(), [], np.arange(len(points)).reshape(-1, 3).tolist())
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def shown(obj):
    """Return the points of an overlay, Blender's world."""
    if obj.type == "CURVE":
        return np.array([point.co[:3] for point in obj.data.splines[0].points])
    return np.array([vertex.co for vertex in obj.data.vertices])


def inside(points):
    """Convert points of an overlay to the network frame, without the overlays' lift."""
    return frames.to_network(points) - [0, drawing.LIFT, 0]


@pytest.mark.parametrize(
    ("name", "operator", "function"),
    [
        (
            "SAMP Grid Sofa",
            lambda: bpy.ops.samp.voxelise(target="Sofa"),
            lambda: previews.voxelise(bpy.context, "Sofa"),
        ),
        (
            "SAMP Navmesh",
            lambda: bpy.ops.samp.build_navmesh(radius=0.3, cell=0.1),
            lambda: previews.build_navmesh(bpy.context, Agent(radius=0.3), 0.1),
        ),
        (
            "SAMP Path",
            lambda: bpy.ops.samp.plan_path(target="Sofa", use_start=True, start=(-3, 3, 0)),
            lambda: previews.plan_path(bpy.context, "Sofa", start=(-3, 3, 0)),
        ),
    ],
)
def test_operators_equal_their_functions(name, operator, function):
    scene = read_scene.read_scene(bpy.context)
    assert operator() == {"FINISHED"}
    one = bpy.data.objects[name]
    points = shown(one)
    assert len(points) > 2 and one.hide_render
    function()
    two = bpy.data.objects[name]
    np.testing.assert_allclose(shown(two), points, atol=2e-5)
    assert len([obj for obj in bpy.data.objects if obj.name.startswith(name)]) == 1, "drawn anew, not twice"
    after = read_scene.read_scene(bpy.context)
    assert after.names == scene.names and np.array_equal(after.triangles, scene.triangles)


def test_the_grid_lies_on_its_object():
    obj, grid = previews.voxelise(bpy.context, "Sofa")
    points = frames.to_network(shown(obj))
    sofa = layouts.sofa((1.5, 1.0), 2.0)
    assert (points.min(0) > sofa.min((0, 1)) - 0.02).all() and (points.max(0) < sofa.max((0, 1)) + 0.02).all()
    assert len(points) == 8 * (grid.occupancy > 0).sum()
    cubes = points.reshape(-1, 8, 3)
    np.testing.assert_allclose(cubes.mean(1), grid.centres[grid.occupancy > 0], atol=1e-5)
    edge = np.linalg.norm(cubes[:, 4] - cubes[:, 0], axis=1)
    np.testing.assert_allclose(edge, (grid.occupancy * grid.cell_size[0])[grid.occupancy > 0], atol=1e-5)


def test_the_navmesh_lies_on_the_floor():
    obj, mesh = previews.build_navmesh(bpy.context)
    assert np.abs(inside(shown(obj))[:, 1]).max() < 0.02
    assert len(obj.data.polygons) == len(mesh) and all(p.normal.z > 0.99 for p in obj.data.polygons)
    area = sum(polygon.area for polygon in obj.data.polygons)
    assert abs(area - mesh.area) < 0.05 and 35 < area < 64


def test_path_from_the_character_to_the_front_of_the_sofa():
    character.create_character(bpy.context, location=(-3, 2, 0))
    obj, path = previews.plan_path(bpy.context, "Sofa")
    points = shown(obj)
    np.testing.assert_allclose(points[0, :2], (-3, 2), atol=0.06)
    np.testing.assert_allclose(inside(points), path.waypoints, atol=1e-5)
    end = inside(points)[-1] - [1.5, 0, 1.0]
    assert 0.4 < np.hypot(end[0], end[2]) < 1.3
    assert end @ frames.yaw_direction(2.0) > 0.4


def test_path_passes_the_way_points_and_begins_at_the_start_marker():
    owner = character.create_character(bpy.context, {}, (-3.0, -3.0, 0.0))
    marker = start_marker.show(bpy.context, owner)
    marker.location.x += 0.5
    there = (-3.0, 2.5, 0.0)
    waypoints.add(bpy.context, there)
    line, path = previews.plan_path(bpy.context, "Sofa")
    begin = frames.to_network(np.array(marker.matrix_world.translation))
    assert np.abs((path.waypoints[0] - begin)[[0, 2]]).max() < 0.05
    assert np.abs(path.waypoints - frames.to_network(np.array(there))).max(1).min() < 0.05
    assert len(shown(line)) == len(path.waypoints)


def test_path_to_a_point():
    bpy.context.scene.cursor.location = (3, -3, 0)
    assert bpy.ops.samp.plan_path(to_cursor=True, use_start=True, start=(-3, 3, 0)) == {"FINISHED"}
    points = shown(bpy.data.objects["SAMP Path"])
    np.testing.assert_allclose(points[[0, -1], :2], [(-3, 3), (3, -3)], atol=0.06)


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: previews.voxelise(bpy.context, "Sofo"), SampError, "'Sofa'"),
        (lambda: previews.plan_path(bpy.context), SampError, "The path has no end"),
        (lambda: previews.plan_path(bpy.context, "Walls"), SampError, "no place to sit"),
        (lambda: previews.plan_path(bpy.context, to=(0, 0, 0), start=(50, 0, 0)), PathError, "start is"),
        (lambda: previews.build_navmesh(bpy.context, Agent(radius=5)), PathError, "smaller"),
    ],
)
def test_errors_are_one_sentence(call, error, words):
    before = set(bpy.data.objects.keys())
    with pytest.raises(error, match=words):
        call()
    assert set(bpy.data.objects.keys()) == before


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: bpy.ops.samp.voxelise(target="Nothing here"), "There is no 'Nothing here'"),
        (lambda: bpy.ops.samp.voxelise(), "No furniture is selected"),
        (lambda: bpy.ops.samp.plan_path(), "No furniture is selected"),
        (lambda: bpy.ops.samp.build_navmesh(radius=2.0, cell=0.2, height=5), "smaller"),
    ],
)
def test_operators_report_errors(call, words):
    if "smaller" in words:
        bpy.data.objects.remove(bpy.data.objects["Floor"])
        add("Shaft", layouts.floor(3, 3))
        bpy.data.objects.remove(bpy.data.objects["Walls"])
    with pytest.raises(RuntimeError, match=words):
        call()


def test_polls():
    for operator in (bpy.ops.samp.voxelise, bpy.ops.samp.build_navmesh, bpy.ops.samp.plan_path):
        assert operator.poll()
    bpy.context.view_layer.objects.active = bpy.data.objects["Sofa"]
    bpy.ops.object.mode_set(mode="EDIT")
    for operator in (bpy.ops.samp.voxelise, bpy.ops.samp.build_navmesh, bpy.ops.samp.plan_path):
        assert not operator.poll()


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("SAMP Grid Sofa", lambda: bpy.ops.samp.voxelise("EXEC_DEFAULT", True, target="Sofa")),
        ("SAMP Navmesh", lambda: bpy.ops.samp.build_navmesh("EXEC_DEFAULT", True, cell=0.1)),
        ("SAMP Path", lambda: bpy.ops.samp.plan_path("EXEC_DEFAULT", True, target="Sofa")),
    ],
)
def test_undo_is_one_step(name, call):
    bpy.context.scene.cursor.location = (-3, 3, 0)
    bpy.ops.ed.undo_push(message="Room")
    assert call() == {"FINISHED"} and name in bpy.data.objects
    bpy.ops.ed.undo()
    assert name not in bpy.data.objects and drawing.COLLECTION not in bpy.data.collections
    assert {"Sofa", "Floor", "Walls", "Table"} <= set(bpy.data.objects.keys())
