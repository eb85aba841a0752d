"""Sub-goals in the scene: arrows with ghost bodies, which follow, are saved, and are no part of the scene."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
import untrained
from mathutils import Vector
from samp_blender.samp_addon import frames
from samp_blender.samp_addon.blender.character import armature, character, characters
from samp_blender.samp_addon.blender.overlays import drawing
from samp_blender.samp_addon.blender.scene import candidates, read_scene
from samp_blender.samp_addon.blender.sub_goals import (
    arrows,
    clicking,
    following,
    ghosts,
    placing,
    stored,
)
from samp_blender.samp_addon.blender.takes import baking
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.methods import registry
from samp_blender.samp_addon.pipeline.job import Job
from untrained import AIR, BED, FAR, FLOOR, SEAT, SHELF


@pytest.fixture(autouse=True)
def _method(monkeypatch):
    monkeypatch.setitem(registry.METHODS, "long_term", untrained.method())


@pytest.fixture
def owner():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.context.scene.render.fps = 30
    untrained.furnish(bpy.context.scene)
    return character.create_character(bpy.context, location=(-0.5, 2.5, 0.0))


def add(owner, point, yaw=None):
    return placing.add(bpy.context, owner, frames.to_network(point), yaw)


def body(arrow):
    """Vertices (V, 3) of an arrow's ghost in the world."""
    bpy.context.view_layer.update()
    ghost = ghosts.find(arrow)
    return np.array([ghost.matrix_world @ vertex.co for vertex in ghost.data.vertices])


@pytest.mark.parametrize("point, action", [(FLOOR, "idle"), (SEAT, "sit"), (BED, "lie")])
def test_where_a_body_is_placed_says_what_it_does(owner, point, action):
    arrow = add(owner, point)
    assert arrow[stored.ACTION_KEY] == action and arrow.type == "EMPTY"
    assert arrow.name == "Sub-goal 1 of Human"
    # The arrow is where the artist wanted it, the body above it, with feet or back not below the floor.
    np.testing.assert_allclose(arrow.matrix_world.translation, point, atol=1e-6)
    skin = body(arrow)
    assert np.linalg.norm(stored.body(arrow).root[0, [0, 2]] - [point[0], -point[1]]) < 0.4
    assert skin[:, 2].min() > -0.12 and len(skin) > 1000


def test_furniture_decides_the_facing(owner):
    assert abs(frames.wrap_angle(arrows.read(add(owner, SEAT)).yaw - np.pi)) < 0.3
    towards = arrows.read(add(owner, FLOOR)).yaw
    way = np.array(FLOOR) - SEAT
    assert frames.wrap_angle(towards - np.arctan2(way[0], -way[1])) == pytest.approx(0, abs=1e-6)
    assert arrows.read(add(owner, FAR, 1.0)).yaw == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(
    "point, message",
    [(AIR, "is in the air; put it onto"), (SHELF, "nobody can sit or lie"), ((9.0, np.nan, 0.0), "finite")],
)
def test_a_point_that_cannot_be_one_adds_nothing(owner, point, message):
    before = set(bpy.data.objects), set(bpy.data.collections), set(bpy.data.meshes)
    with pytest.raises(SampError, match=message):
        add(owner, point)
    assert (set(bpy.data.objects), set(bpy.data.collections), set(bpy.data.meshes)) == before


def test_ghosts_are_not_rendered_not_selectable_and_not_read(owner):
    empty = read_scene.read_scene(bpy.context, characters.people(bpy.context))
    people = characters.people(bpy.context)
    arrow = add(owner, SEAT)
    ghost = ghosts.find(arrow)
    assert ghost.hide_render and ghost.hide_select and arrow.hide_render and ghost.parent == arrow
    assert arrows.collection(bpy.context.scene).hide_render
    after = read_scene.read_scene(bpy.context, characters.people(bpy.context))
    assert after.names == empty.names and np.array_equal(after.triangles, empty.triangles)
    assert characters.people(bpy.context) == people and not armature.is_smplx(ghost)
    assert not candidates.is_furniture(ghost) and not candidates.is_furniture(arrow)
    # A click passes the ghost, and clearing overlays leaves it.
    down = Vector((SEAT[0], SEAT[1], 3.0)), Vector((0.0, 0.0, -1.0))
    assert clicking.surface_on(bpy.context, *down)[2] == pytest.approx(0.45, abs=1e-5)
    assert drawing.clear(bpy.context) == 0 and ghosts.find(arrow) == ghost


def test_a_moved_arrow_takes_its_body_along_and_gets_a_new_one(owner):
    arrow = add(owner, FLOOR)
    before, pose = body(arrow), list(arrow[stored.POSE_KEY])
    assert not following.is_behind(bpy.context.scene)
    arrow.location = SEAT
    shift = np.linalg.norm(np.array(SEAT) - FLOOR)
    assert np.linalg.norm(body(arrow).mean(0) - before.mean(0)) == pytest.approx(shift, abs=0.3)
    assert following.is_behind(bpy.context.scene)
    arrows.place(bpy.context, arrow, arrows.Spot(frames.to_network(SEAT), np.pi))
    following.follow()
    assert arrow[stored.ACTION_KEY] == "sit" and list(arrow[stored.POSE_KEY]) != pose
    assert not following.is_behind(bpy.context.scene)


def test_changes_are_noticed_by_themselves(owner):
    following.register()
    try:
        arrow = add(owner, FLOOR)
        arrow.location = FAR
        bpy.context.view_layer.update()
        assert bpy.app.timers.is_registered(following.follow)
    finally:
        following.unregister()
    assert not bpy.app.timers.is_registered(following.follow)


def test_a_place_without_room_is_marked_and_named_by_the_bake(owner):
    arrows_ = [add(owner, FLOOR), add(owner, FAR)]
    arrows_[1].location = AIR
    assert placing.update(bpy.context, owner) == [
        "'Sub-goal 2 of Human' is in the air; put it onto a floor, a seat or a bed."
    ]
    assert ghosts.find(arrows_[1]).data.materials[0].name == "SAMP ghost misplaced"
    assert not following.is_behind(bpy.context.scene)
    with pytest.raises(SampError, match="'Sub-goal 2 of Human' is in the air"):
        baking.run(bpy.context, Job(action="", method="long_term"))
    arrows_[1].location = FAR
    assert placing.update(bpy.context, owner) == [] and not stored.problem(arrows_[1])


@pytest.mark.parametrize(
    "rotation, scale, message",
    [((0.0, 0.0, 0.0), 1.0, "points up or down"), ((np.pi / 2, 0.0, 0.0), 0.0, "scale of zero")],
)
def test_arrows_without_a_facing(owner, rotation, scale, message):
    arrow = add(owner, FLOOR)
    arrow.rotation_euler, arrow.scale = rotation, (scale,) * 3
    (problem,) = placing.update(bpy.context, owner)
    assert message in problem and arrow.name in problem


def test_another_body_differs_and_a_pinned_one_stays(owner):
    arrow = add(owner, FLOOR)
    first = body(arrow)
    placing.another(bpy.context, arrow)
    second = body(arrow)
    assert np.abs(second - first).max() > 0.005
    stored.pin(arrow)
    with pytest.raises(SampError, match="is pinned; unpin it"):
        placing.another(bpy.context, arrow)
    pose = stored.body(arrow)
    arrows.place(bpy.context, arrow, arrows.Spot(frames.to_network(FAR), 2.0))
    assert placing.update(bpy.context, owner) == []
    moved = stored.body(arrow)
    np.testing.assert_allclose(moved.rotations[0, 1:], pose.rotations[0, 1:], atol=1e-6)
    assert ghosts.find(arrow).data.materials[0].name == "SAMP ghost pinned"
    arrows.place(bpy.context, arrow, arrows.Spot(frames.to_network(SEAT), np.pi))
    (problem,) = placing.update(bpy.context, owner)
    assert "is on furniture now and its pinned body is not; unpin it" in problem
    stored.pin(arrow, False)
    assert placing.update(bpy.context, owner) == [] and arrow[stored.ACTION_KEY] == "sit"


@pytest.mark.parametrize("here", [False, True])
def test_the_character_s_pose_becomes_the_sub_goal_s(owner, here):
    arrow = add(owner, FLOOR, 1.0)
    owner.pose.bones["left_elbow"].rotation_quaternion = (0.8, 0.0, 0.6, 0.0)
    bpy.context.view_layer.update()
    placing.use_pose(bpy.context, arrow, here)
    shown, kept = armature.posed(owner), stored.body(arrow)
    np.testing.assert_allclose(
        np.abs((shown.rotations[0, 1:22] * kept.rotations[0, 1:22]).sum(-1)), 1, atol=1e-5
    )
    assert stored.is_pinned(arrow)
    place = np.array((-0.5, 2.5, 0.0) if here else FLOOR)
    assert np.linalg.norm(kept.root[0, [0, 2]] - [place[0], -place[1]]) < 0.1
    assert body(arrow)[:, 2].min() == pytest.approx(0.0, abs=0.02)


def test_order_names_and_removal(owner):
    made = [add(owner, point) for point in (FLOOR, SEAT, FAR)]
    made[1].name = "Tea"
    arrows.move(bpy.context, made[2], -1)
    assert arrows.of(bpy.context, owner) == [made[0], made[2], made[1]]
    assert [arrow.name for arrow in made] == ["Sub-goal 1 of Human", "Tea", "Sub-goal 2 of Human"]
    with pytest.raises(SampError, match="'Tea' is the last sub-goal already"):
        arrows.move(bpy.context, made[1], 1)
    placing.remove(bpy.context, made[0])
    assert made[2].name == "Sub-goal 1 of Human" and len(arrows.of(bpy.context, owner)) == 2
    assert placing.clear(bpy.context, owner) == 2 and arrows.collection(bpy.context.scene) is None
    assert not any(mesh.name.startswith("Body of") for mesh in bpy.data.meshes)
    assert not any(material.name.startswith("SAMP ghost") for material in bpy.data.materials)


def test_copied_and_deleted_arrows(owner):
    """As the artist does it in the viewport: a copy is another sub-goal; with an arrow goes its body."""
    arrow = add(owner, FLOOR)
    copy = arrow.copy()
    arrows.home(bpy.context).objects.link(copy)
    copy.location = FAR
    assert placing.update(bpy.context, owner) == []
    assert arrows.of(bpy.context, owner) == [arrow, copy] and ghosts.find(copy) != ghosts.find(arrow)
    bpy.data.objects.remove(arrow)
    assert following.is_behind(bpy.context.scene)
    following.follow()
    assert len([obj for obj in bpy.data.objects if ghosts.is_ghost(obj)]) == 1
    assert copy.name == "Sub-goal 1 of Human"


def test_each_character_has_its_own(owner):
    other = character.create_character(bpy.context, location=(2.5, 0.0, 0.0), name="Other")
    add(owner, FLOOR)
    mine, theirs = [add(owner, SEAT)], [add(other, FAR)]
    assert len(arrows.of(bpy.context, owner)) == 2 and arrows.of(bpy.context, other) == theirs
    assert theirs[0].name == "Sub-goal 1 of Other" and mine[0].name == "Sub-goal 2 of Human"
    for obj in bpy.context.selected_objects:
        obj.select_set(False)
    with pytest.raises(SampError, match="Several characters have sub-goals"):
        baking.run(bpy.context, Job(action="", method="long_term"))
    before = [np.array(arrow.matrix_world) for arrow in (*mine, *theirs)]
    owner.location.x += 1.0
    bpy.context.view_layer.update()
    after = [np.array(arrow.matrix_world) for arrow in (*mine, *theirs)]
    assert np.array_equal(before, after)
    bpy.data.objects.remove(owner)
    assert arrows.owners(bpy.context) == [other]
    assert placing.clear(bpy.context, other) == 3


def test_a_bake_passes_the_bodies_that_are_shown(owner):
    made = [add(owner, point) for point in (FLOOR, SEAT, FAR)]
    shown = [stored.body(arrow) for arrow in made]
    result = baking.run(bpy.context, Job(action="", method="long_term", hold=0.5, variants=2))
    assert result.owner == owner and len(result.actions) == 2 and not result.failures
    for variant in result.variants:
        assert variant["method"] == "long_term" and len(variant["sub_goals"]) == 3
        for passed, pose in zip(variant["sub_goals"], shown, strict=True):
            np.testing.assert_allclose(passed["position"], frames.to_blender(pose.root[0]), atol=1e-4)
    assert [stored.problem(arrow) for arrow in made] == ["", "", ""]


@pytest.mark.parametrize("count, message", [(0, "There are no sub-goals"), (1, "There is only one sub-goal")])
def test_too_few_to_bake(owner, count, message):
    for point in (FLOOR, FAR)[:count]:
        add(owner, point)
    with pytest.raises(SampError, match=message):
        baking.run(bpy.context, Job(action="", method="long_term"))
