"""The walkable surface: floors, obstacles, and errors."""

from __future__ import annotations

import math

import numpy as np
import pytest
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.scene.navmesh import heightfield, navmesh
from samp_blender.samp_addon.scene.navmesh.navmesh import Agent
from samp_blender.tests.support import layouts


def walkable_at(mesh, x, z, height=0.0, within=0.1):
    """Return whether there is walkable ground at a place and height."""
    place = mesh.ground.at(np.array([x, height, z]))
    return bool(
        place >= 0
        and mesh.pieces.owner[place] >= 0
        and abs(mesh.ground.places.height[place] - height) <= within
    )


def join(*parts):
    return np.concatenate(parts)


FLOOR = layouts.floor()
WALL = layouts.box((-3, 0, -0.05), (1, 2, 0.05))
LOW_LAMP = layouts.box((-0.1, 1.5, -0.1), (0.1, 2.5, 0.1))


@pytest.mark.parametrize(
    ("name", "triangles", "walkable", "blocked"),
    [
        ("bare floor", FLOOR, [(0, 0), (2.7, 2.7)], [(2.85, 0), (0, -2.9), (3.5, 0)]),
        ("a wall", join(FLOOR, WALL), [(0, 0.32), (2, 0)], [(0, 0), (0, 0.2)]),
        ("under a table", join(FLOOR, layouts.table()), [(1.1, 0)], [(0, 0), (0.4, 0.2), (0.95, 0)]),
        ("under a high canopy", join(FLOOR, layouts.table(height=2.2)), [(0, 0), (0.4, 0)], [(0.75, 0.4)]),
        ("a low lamp", join(FLOOR, LOW_LAMP), [(0.5, 0)], [(0, 0)]),
        ("a high lamp", join(FLOOR, layouts.box((-0.1, 1.9, -0.1), (0.1, 2.5, 0.1))), [(0, 0)], []),
        ("a rug", join(FLOOR, layouts.box((-1, 0, -1), (1, 0.02, 1))), [(0, 0), (1, 0), (1.5, 0)], []),
        ("a low step", join(FLOOR, layouts.box((0, 0, -3), (3, 0.2, 3))), [(0, 0), (-0.1, 0), (-2, 0)], []),
        ("a high step", join(FLOOR, layouts.box((0, 0, -3), (3, 0.3, 3))), [(-2, 0)], [(-0.1, 0)]),
        ("a floor seen from below", FLOOR[:, ::-1], [(0, 0)], []),
    ],
)  # fmt: skip
def test_walkable_and_blocked_places(name, triangles, walkable, blocked):
    mesh = navmesh.build(triangles)
    assert mesh.laid_ground is None
    for x, z in walkable:
        heights = (0.0, 0.02, 0.2, 0.3)
        assert any(walkable_at(mesh, x, z, h) for h in heights), (x, z)
    for x, z in blocked:
        assert not walkable_at(mesh, x, z), (x, z)


@pytest.mark.parametrize("radius", [0.15, 0.25, 0.4])
@pytest.mark.parametrize("yaw", [0.0, 0.6])
def test_distance_to_obstacles_is_the_radius(radius, yaw):
    block = layouts.moved(layouts.box((-0.5, 0, -0.5), (0.5, 1, 0.5)), yaw)
    mesh = navmesh.build(join(FLOOR, block), Agent(radius=radius))
    local = mesh.points @ layouts.moved(np.eye(3), -yaw).T.T
    gap = np.linalg.norm(np.maximum(np.abs(local[:, [0, 2]]) - 0.5, 0), axis=1)
    assert radius - 0.02 <= gap[mesh.points[:, 1] < 0.1].min() <= radius + 0.08


@pytest.mark.parametrize(("degrees", "passable"), [(10, True), (30, True), (38, True), (50, False)])
def test_slopes(degrees, passable):
    mesh = navmesh.build(join(layouts.floor(8, 12), layouts.ramp(degrees)))
    run = 1.5 / math.tan(math.radians(degrees))
    assert walkable_at(mesh, 0, run / 2, 0.75) == passable
    if passable:
        top = mesh.nearest(np.array([0, 1.5, run + 1.5]))
        assert mesh.island_of(top) == mesh.island_of(mesh.nearest(np.array([0, 0, -2.0])))


@pytest.mark.parametrize(("rise", "passable"), [(0.17, True), (0.25, True), (0.32, False)])
def test_stairs(rise, passable):
    mesh = navmesh.build(join(layouts.floor(8, 12), layouts.stairs(6, rise, 0.3)))
    assert walkable_at(mesh, 0, 0.3 * 3.5, 4 * rise) == passable


def test_stairs_connect_two_storeys():
    upstairs = layouts.floor(6, 3, layouts.STOREY, by=(0, 5.7))
    ground = layouts.floor(6, 14)
    apart = navmesh.build(join(ground, upstairs))
    joined = navmesh.build(join(ground, upstairs, layouts.stairs(15, 0.2, 0.28)))
    for mesh, one in ((apart, False), (joined, True)):
        low, high = (mesh.nearest(np.array([0, h, 5.7])) for h in (0.0, layouts.STOREY))
        heights = mesh.ground.places.height[[low, high]]
        np.testing.assert_allclose(heights, [0, layouts.STOREY], atol=0.03)
        assert (mesh.island_of(low) == mesh.island_of(high)) == one


def test_tops_of_furniture_are_not_walkable():
    bed = layouts.box((-1, 0, -1), (1, 0.5, 1))
    mesh = navmesh.build(join(FLOOR, bed, layouts.table((2, 2))))
    assert mesh.points[:, 1].max() < 0.1
    assert mesh.points[mesh.walkable == mesh.nearest(np.array([0, 0.6, 0]))][0, 1] < 0.1


def test_polygons_are_convex_and_cover_the_walkable_area():
    mesh = navmesh.build(layouts.furnished(triangles=5000))
    corners = mesh.polygons
    across = corners[:, :, [0, 2]]
    edges = np.roll(across, -1, axis=1) - across
    following = np.roll(edges, -1, axis=1)
    turn = edges[..., 1] * following[..., 0] - edges[..., 0] * following[..., 1]
    assert (turn > 0).all(), "counter-clockwise seen from above, all corners convex"
    diagonal = across[:, 2] - across[:, 0]
    assert abs(np.abs(diagonal.prod(axis=1)).sum() - mesh.area) < 1e-6
    assert (mesh.pieces.owner[mesh.walkable] >= 0).all() and len(mesh) < 2000


def test_links_are_symmetric():
    mesh = navmesh.build(layouts.furnished(3, triangles=5000))
    links = mesh.ground.links
    for direction in range(4):
        here = np.flatnonzero(links[direction] >= 0)
        assert (links[(direction + 2) % 4, links[direction, here]] == here).all()


@pytest.mark.parametrize(
    ("name", "triangles", "floor_height", "expected"),
    [
        ("a floor", FLOOR, None, None),
        ("a crowded room", layouts.furnished(pieces=20, triangles=4000), None, None),
        ("a sofa alone", layouts.sofa(), None, 0.05),
        ("a raised chair alone", layouts.moved(layouts.sofa(width=0.6), by=(0, 0.3, 0)), None, 0.35),
        ("furniture without a floor", join(layouts.sofa((-2, 0)), layouts.table((2, 1))), None, 0.0),
        ("a requested floor", layouts.sofa(), 0.0, 0.0),
        ("a requested floor in the air", FLOOR, 1.0, 1.0),
    ],
)
def test_a_missing_floor_is_added(name, triangles, floor_height, expected):
    mesh = navmesh.build(triangles, floor_height=floor_height)
    assert mesh.laid_ground == (None if expected is None else pytest.approx(expected, abs=1e-6))
    if expected is not None:
        low, high = triangles.min((0, 1)), triangles.max((0, 1))
        for x, z in ((low[0] - 1, low[2] - 1), (high[0] + 1, high[2] + 1)):
            assert walkable_at(mesh, x, z, expected)


def test_an_added_floor_extends_to_start_and_goal():
    mesh = navmesh.build(layouts.sofa(), cover=np.array([[7.0, 0, -6.0]]))
    assert walkable_at(mesh, 7, -6, 0.05)


def test_an_empty_scene_with_a_floor():
    mesh = navmesh.build(np.zeros((0, 3, 3)), floor_height=0.0, cover=np.array([[0, 0, 0], [3.0, 0, 0]]))
    assert walkable_at(mesh, 0, 0) and walkable_at(mesh, 3, 0)


@pytest.mark.parametrize(
    ("triangles", "agent", "words"),
    [
        (np.zeros((0, 3, 3)), Agent(), "no faces"),
        (join(layouts.floor(3, 3), layouts.floor(3, 3, 1.0)), Agent(radius=4), "walked on"),
    ],
)
def test_scenes_without_ground_raise_an_error(triangles, agent, words):
    with pytest.raises(SampError, match=words):
        navmesh.build(triangles, agent)


@pytest.mark.parametrize("size", [60.0, 400.0])
def test_large_scenes_are_cropped_around_start_and_goal(size):
    triangles = join(layouts.floor(size, size), layouts.sofa((20, 20)))
    mesh = navmesh.build(triangles, cover=np.array([[18.0, 0, 20], [22.0, 0, 20]]))
    assert mesh.ground.grid.cell == pytest.approx(0.05)
    assert walkable_at(mesh, 18, 20) and not walkable_at(mesh, 20, 20)
    if size > 100:
        return
    coarse = navmesh.build(triangles)
    assert coarse.ground.grid.cell > 0.05 and np.prod(coarse.ground.grid.shape) < 1.1 * navmesh.MAX_COLUMNS


def test_a_sky_dome_has_no_effect():
    sky = layouts.ball(2000, (90, 90, 90), (0, 0, 0))
    mesh = navmesh.build(join(layouts.floor(20, 20), sky), cover=np.zeros((1, 3)))
    assert walkable_at(mesh, 0, 0) and walkable_at(mesh, 9, 9)


def test_degenerate_triangles_have_no_effect():
    rng = np.random.default_rng(0)
    broken = np.repeat(rng.uniform(-2, 2, (50, 1, 3)), 3, axis=1)
    slivers = np.concatenate(
        [broken[:, :1] * 0 + 0.01, broken[:, :1] * 0 + 0.02, broken[:, :1] * 0 + 0.03], 1
    )
    mesh = navmesh.build(join(FLOOR, broken * [1, 0, 1], slivers * [1, 0, 1]))
    assert walkable_at(mesh, 1, 1)


def test_free_places_are_on_the_same_storey_and_not_on_stairs():
    upstairs = layouts.floor(6, 3, layouts.STOREY, by=(0, 5.7))
    mesh = navmesh.build(join(layouts.floor(6, 14), upstairs, layouts.stairs(15, 0.2, 0.28)))
    for near, height in (([0, 0.6, -3.0], 0.0), ([0, 3.6, 5.7], layouts.STOREY)):
        for seed in range(20):
            place, _ = navmesh.free_place(mesh, near, (0.5, 9), np.random.default_rng(seed))
            assert abs(place[1] - height) < 0.1


def test_free_places_are_not_in_enclosed_pockets():
    shut = join(layouts.box((-1, 0, -1.6), (1, 1, -1.5)), layouts.box((-1, 0, -2.6), (1, 1, -2.5)))
    sides = join(layouts.box((-1, 0, -2.5), (-0.9, 1, -1.6)), layouts.box((0.9, 0, -2.5), (1, 1, -1.6)))
    mesh = navmesh.build(join(layouts.floor(6, 6), shut, sides))
    assert len(np.unique(mesh.islands)) == 2
    place, _ = navmesh.free_place(mesh, [0, 0.6, -2.05], (0.2, 0.5), np.random.default_rng(0))
    assert abs(place[0]) > 1 or place[2] > -1.5 or place[2] < -2.6


@pytest.mark.parametrize("cells", [50, 4000, 1 << 62])
def test_cells_are_the_same_by_table_and_by_sorting(cells):
    rng = np.random.default_rng(0)
    key, flat = rng.integers(min(cells, 4000), size=500), rng.random(500) < 0.5
    sorting = heightfield._by_sorting(key, flat, cells)
    for one, other in zip(heightfield._by_table(key, flat, min(cells, 4000)), sorting, strict=True):
        np.testing.assert_array_equal(one, other)
    for number, chosen in zip(*sorting, strict=True):
        assert key[chosen] == number
        assert flat[chosen] == flat[key == number].any()


@pytest.mark.parametrize("distance", [(0.5, 1.0), (1.5, 3.0), (40.0, 50.0)])
def test_free_places(distance):
    mesh = navmesh.build(layouts.furnished(1, triangles=5000))
    near = mesh.points[len(mesh.points) // 2]
    places = [navmesh.free_place(mesh, near, distance, np.random.default_rng(k)) for k in range(20)]
    island = mesh.island_of(mesh.nearest(near))
    for position, yaw in places:
        number = mesh.nearest(position)
        np.testing.assert_allclose(mesh.ground.points(number), position)
        assert mesh.island_of(number) == island
        away = np.hypot(*(position - near)[[0, 2]])
        assert distance[0] - 1e-9 <= away <= distance[1] + 1e-9 or distance[0] == 40.0
        facing = np.array([math.sin(yaw), math.cos(yaw)])
        assert facing @ (near - position)[[0, 2]] >= -1e-6
    again = navmesh.free_place(mesh, near, distance, np.random.default_rng(0))
    np.testing.assert_array_equal(again[0], places[0][0])
    assert len({tuple(position) for position, _ in places}) > 5 or distance[0] == 40.0


def test_low_furniture_is_rough_ground_and_not_a_start():
    futon = layouts.box((-1, 0, -1), (1, 0.18, 1))
    mesh = navmesh.build(join(FLOOR, futon))
    rough = mesh.ground.rough[mesh.walkable]
    assert rough[mesh.points[:, 1] > 0.1].all() and not rough.all()
    for seed in range(20):
        place, _ = navmesh.free_place(mesh, [0, 0.3, 0], (0.0, 2.5), np.random.default_rng(seed))
        assert place[1] < 0.1
    sunken = join(
        layouts.floor(3, 3, 0.0), layouts.floor(8, 3, 0.2, by=(0, 3)), layouts.floor(8, 3, 0.2, by=(0, -3))
    )
    mesh = navmesh.build(sunken)
    middle = mesh.ground.at(np.zeros(3))
    assert not mesh.ground.rough[middle], "a sunken room is not furniture"
