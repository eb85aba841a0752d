"""Goal arrows: drawn by the operator, moved and selected by the artist, and read back."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from samp_blender.samp_addon import frames
from samp_blender.samp_addon.blender.overlays import goal_arrows
from samp_blender.samp_addon.blender.scene import read_scene
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.scene.seats import seats
from samp_blender.training import furniture

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def sofa():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    made = add("Sofa", furniture.generate("sofa", np.random.default_rng(3)).triangles)
    made.matrix_world = Matrix.Translation((1, 2, 0.5)) @ Matrix.Rotation(0.7, 4, "Z")
    bpy.context.view_layer.update()
    return made


def add(name, triangles):
    points = frames.to_blender(triangles.reshape(-1, 3))
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], np.arange(len(points)).reshape(-1, 3).tolist())
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    return obj


def target():
    return read_scene.read_target(bpy.context, "Sofa")


def places(arrows):
    return np.array([arrow.matrix_world for arrow in arrows])


def test_operator_equals_its_function(sofa):
    assert bpy.ops.samp.sample_goals(target="Sofa", count=3, seed=5) == {"FINISHED"}
    by_operator = places(goal_arrows.arrows(bpy.context, "Sofa"))
    by_function = places(goal_arrows.sample_goals(bpy.context, "Sofa", "sit", 3, 5))
    np.testing.assert_allclose(by_operator, by_function, atol=1e-6)
    assert len(goal_arrows.arrows(bpy.context, "Sofa")) == 3, "new arrows take the place of the old"


def test_default_target_is_the_active_object_or_the_arrows_target(sofa):
    bpy.context.view_layer.objects.active = sofa
    assert bpy.ops.samp.sample_goals(count=2) == {"FINISHED"}
    bpy.context.view_layer.objects.active = goal_arrows.arrows(bpy.context, "Sofa")[0]
    assert bpy.ops.samp.sample_goals(count=1) == {"FINISHED"}
    assert len(goal_arrows.arrows(bpy.context, "Sofa")) == 1


def test_click_on_a_part_selects_the_whole_piece(sofa):
    parent = bpy.data.objects.new("Couch", None)
    cushion = add("Cushion", np.array([[[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]]]) + [0.0, 0.45, 0.0])
    bpy.context.scene.collection.objects.link(parent)
    sofa.parent = cushion.parent = parent
    bpy.context.view_layer.update()
    bpy.context.view_layer.objects.active = cushion
    assert bpy.ops.samp.sample_goals(count=2) == {"FINISHED"}
    assert len(goal_arrows.arrows(bpy.context, "Couch")) == 2


def test_arrows_round_trip(sofa):
    before = seats.find_goals(target().triangles, "sit")
    goal_arrows.add_goals(bpy.context, before, "Sofa")
    after = goal_arrows.read_goals(bpy.context, target(), "sit")
    assert len(after) == len(before)
    np.testing.assert_allclose([g.position for g in after], [g.position for g in before], atol=1e-3)
    np.testing.assert_allclose([g.direction for g in after], [g.direction for g in before], atol=1e-3)
    assert goal_arrows.read_goals(bpy.context, target(), "lie") == []


def test_arrow_points_along_the_facing(sofa):
    goal = seats.find_goals(target().triangles, "sit")[0]
    arrow = goal_arrows.add_goals(bpy.context, [goal], "Sofa")[0]
    tip = np.array(arrow.matrix_world @ Matrix.Translation((0, 0, 1)).translation)
    np.testing.assert_allclose(frames.to_network(tip - np.array(arrow.location)), goal.direction, atol=1e-6)


def test_moved_arrows_are_snapped_to_the_surface(sofa):
    arrow = goal_arrows.add_goals(bpy.context, seats.find_goals(target().triangles, "sit")[:1], "Sofa")[0]
    before = goal_arrows.read_goals(bpy.context, target())[0]
    arrow.matrix_world = Matrix.Translation((0, 0, 0.25)) @ arrow.matrix_world
    bpy.context.view_layer.update()
    after = goal_arrows.read_goals(bpy.context, target())[0]
    np.testing.assert_allclose(after.position, before.position, atol=1e-3)


def test_selected_arrows_are_used_and_deleted_ones_are_not(sofa):
    made = goal_arrows.add_goals(bpy.context, seats.find_goals(target().triangles, "sit"), "Sofa")
    assert len(made) >= 2
    made[1].select_set(True)
    chosen = goal_arrows.read_goals(bpy.context, target())
    assert len(chosen) == 1
    np.testing.assert_allclose(chosen[0].position, goal_arrows.read_arrow(made[1]).position, atol=1e-3)
    bpy.data.objects.remove(made[1])
    assert len(goal_arrows.read_goals(bpy.context, target())) == len(made) - 1


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (Matrix.Translation((0, 0, 0)) @ Matrix.Rotation(np.pi / 2, 4, "Y"), "points up or down"),
        (Matrix.Rotation(np.pi, 4, "X"), "no place to sit at the arrow"),
    ],
    ids=["upright", "into the back"],
)
def test_invalid_arrows_raise(sofa, change, words):
    arrow = goal_arrows.add_goals(bpy.context, seats.find_goals(target().triangles, "sit")[:1], "Sofa")[0]
    arrow.matrix_world = arrow.matrix_world @ change
    bpy.context.view_layer.update()
    with pytest.raises(SampError, match=words) as caught:
        goal_arrows.read_goals(bpy.context, target())
    assert arrow.name in str(caught.value)


@pytest.mark.parametrize(
    ("options", "words"),
    [({"target": "Sofaa"}, "did you mean 'Sofa'"), ({"target": "Mast"}, "no place to sit")],
)
def test_operator_errors_keep_existing_arrows(sofa, options, words):
    add("Mast", np.array([[[0, 0, 0], [0.1, 0, 0], [0, 3.0, 0]]]) + [4.0, 0, 0])
    goal_arrows.add_goals(bpy.context, seats.find_goals(target().triangles, "sit")[:1], "Sofa")
    with pytest.raises(RuntimeError, match=words):
        bpy.ops.samp.sample_goals(**options)
    assert len(goal_arrows.arrows(bpy.context, "Sofa")) == 1


def test_arrows_are_not_read_as_scene_and_objects_do_not_change(sofa):
    before = (
        read_scene.read_scene(bpy.context).triangles.copy(),
        [o.name for o in bpy.context.selected_objects],
    )
    active = bpy.context.view_layer.objects.active
    assert bpy.ops.samp.sample_goals(target="Sofa", count=2) == {"FINISHED"}
    np.testing.assert_array_equal(read_scene.read_scene(bpy.context).triangles, before[0])
    assert [o.name for o in bpy.context.selected_objects] == before[1]
    assert bpy.context.view_layer.objects.active == active


def test_goals_do_not_face_a_wall_behind_the_target(sofa):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    from samp_blender.training.furniture import shapes

    add("Stool", shapes.box((-0.2, 0, -0.2), (0.2, 0.45, 0.2)))
    add("Wall", shapes.box((-2, 0, 0.3), (2, 2.4, 0.4), 8))
    made = goal_arrows.sample_goals(bpy.context, "Stool", "sit", 6, 1)
    assert max(goal_arrows.read_arrow(arrow).direction[2] for arrow in made) < 0.5
