"""Signed distances against exact ones, on the meshes that artists make."""

import numpy as np
import pytest
import rooms
from samp_blender.samp_addon.scene.distance import orientation, signed_distance
from samp_blender.samp_addon.scene.distance.signed_distance import BAND, CELL
from samp_blender.samp_addon.scene.geometry import area_vectors

LOW, HIGH = np.array([-0.31, 0.02, -0.42]), np.array([0.43, 0.51, 0.37])
FREE = np.random.default_rng(5).uniform(-2, 2, (400, 3)) + [0.0, 3.0, 0.0]


def box(low=LOW, high=HIGH):
    return rooms.box(np.asarray(low, float), np.asarray(high, float))


def box_distance(points, low=LOW, high=HIGH):
    """The exact signed distance of a box, in closed form."""
    middle, half = (low + high) / 2, (high - low) / 2
    away = np.abs(points - middle) - half
    return np.linalg.norm(np.maximum(away, 0), axis=-1) + np.minimum(away.max(-1), 0)


def ball(radius=0.4, steps=24):
    """A closed sphere of triangles about (0, 1, 0)."""
    v, u = np.meshgrid(
        np.linspace(0, np.pi, steps + 1), np.linspace(0, 2 * np.pi, 2 * steps + 1), indexing="ij"
    )
    p = np.stack([np.sin(v) * np.cos(u), np.cos(v), np.sin(v) * np.sin(u)], -1) * radius + [0, 1, 0]
    a, b, c, d = p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]
    triangles = np.concatenate([np.stack(t, 2).reshape(-1, 3, 3) for t in ((a, c, b), (a, d, c))])
    return triangles[np.linalg.norm(area_vectors(triangles), axis=-1) > 1e-9]


def some_points(count=4000, seed=0):
    return np.random.default_rng(seed).uniform(LOW - 0.11, HIGH + 0.11, (count, 3))


def partly_flipped(triangles, seed=1):
    some = np.random.default_rng(seed).random(len(triangles)) < 0.4
    return np.where(some[:, None, None], triangles[:, ::-1], triangles)


MESHES = {
    "as modelled": lambda t: t,
    "flipped": lambda t: t[:, ::-1],
    "half flipped": partly_flipped,
    "corners not welded": lambda t: t + 1e-7 * np.random.default_rng(0).standard_normal(t.shape),
    "twice": lambda t: np.concatenate([t, t]),
    "a box inside it": lambda t: np.concatenate([t, box([-0.1, 0.1, -0.1], [0.1, 0.3, 0.1])[:, ::-1]]),
}


@pytest.mark.parametrize("mesh", MESHES)
def test_a_box_with_any_mesh_defects(mesh):
    field = signed_distance.cached_field(MESHES[mesh](box()), FREE)
    points, exact = some_points(), box_distance(some_points())
    found, _ = field.at(points)
    clear = np.abs(exact) >= CELL
    assert ((found < 0) == (exact < 0))[clear].mean() >= 0.99
    assert (np.abs(found - np.clip(exact, -np.inf, BAND)) <= CELL / 2).mean() >= (
        0.97 if "inside" in mesh else 0.99
    )


@pytest.mark.parametrize("turn", [1, -1])
def test_a_ball_is_exact_to_half_a_cell_with_gradients_pointing_out(turn):
    field = signed_distance.cached_field(ball()[:, ::turn], FREE)
    rng = np.random.default_rng(2)
    way = rng.standard_normal((3000, 3))
    way /= np.linalg.norm(way, axis=-1, keepdims=True)
    exact = rng.uniform(-0.25, 0.1, 3000)
    found, slope = field.at(np.array([0, 1, 0]) + way * (0.4 + exact)[:, None])
    assert (np.abs(found - exact) <= CELL / 2).mean() >= 0.99
    assert ((found < 0) == (exact < 0))[np.abs(exact) >= CELL].mean() >= 0.99
    assert (slope * way).sum(-1).mean() > 0.97


OPEN = {"without a bottom": (1, LOW[1]), "without a front": (2, HIGH[2]), "without a side": (0, LOW[0])}


@pytest.mark.parametrize("name", OPEN)
@pytest.mark.parametrize("turn", [1, -1])
def test_an_open_box_is_still_solid(name, turn):
    axis, at = OPEN[name]
    mesh = box()
    mesh = mesh[~(np.abs(mesh[:, :, axis] - at) < 1e-9).all(1)][:, ::turn]
    points = some_points()
    exact = box_distance(points)
    # Behind the hole the distance refers to the remaining faces: test only the sign, away from the hole.
    away = np.abs(points[:, axis] - at) > 0.1
    found, _ = signed_distance.cached_field(mesh, FREE).at(points[away])
    clear = np.abs(exact[away]) >= CELL
    assert ((found < 0) == (exact[away] < 0))[clear].mean() >= 0.99


def test_what_is_open_upwards_holds_what_lies_in_it():
    bath = box()
    bath = bath[~(np.abs(bath[:, :, 1] - HIGH[1]) < 1e-9).all(1)]
    points = np.random.default_rng(0).uniform(LOW + 0.03, HIGH - 0.03, (500, 3))
    for turn in (1, -1):
        found, _ = signed_distance.cached_field(bath[:, ::turn], FREE).at(points)
        assert (found > 0).all()


def test_a_sheet_has_no_inside():
    sheet = np.array(
        [[[0, 0.5, 0], [0, 0.5, 1], [1, 0.5, 0]], [[1, 0.5, 1], [1, 0.5, 0], [0, 0.5, 1]]], float
    )
    points = np.random.default_rng(0).uniform([0.2, 0.42, 0.2], [0.8, 0.58, 0.8], (500, 3))
    found, _ = signed_distance.cached_field(sheet, FREE).at(points)
    np.testing.assert_allclose(found, np.abs(points[:, 1] - 0.5), atol=CELL / 2)
    assert (found >= 0).all()


def test_gradients_in_a_thin_table_top_point_to_its_nearer_side():
    top = box([-0.5, 0.70, -0.5], [0.5, 0.73, 0.5])
    points = np.array([[0.1, 0.707, 0.1], [0.1, 0.723, 0.1]])
    found, slope = signed_distance.cached_field(top, FREE).at(points)
    np.testing.assert_allclose(found, -0.007, atol=CELL / 4)
    assert slope[0, 1] < 0 < slope[1, 1]


def test_the_inside_of_a_room_modelled_as_a_box_is_not_solid():
    room, stool = box([-2, 0, -2], [2, 2.5, 2]), box([0, 0, 0], [0.5, 0.5, 0.5])
    free = np.random.default_rng(0).uniform([-1.8, 0.1, -1.8], [1.8, 1.8, 1.8], (500, 3))
    for turn in (1, -1):
        field = signed_distance.cached_field(np.concatenate([room[:, ::turn], stool]), free)
        found, _ = field.at(
            np.array([[0.25, 0.3, 0.25], [0.25, 0.7, 0.25], [-1.0, 1.0, -1.0], [0.25, 0.55, 0.25]])
        )
        assert found[0] < -0.1 and found[1] == pytest.approx(BAND, abs=1e-6) == found[2]
        assert found[3] == pytest.approx(0.05, abs=CELL / 2)


def test_blocks_are_cached_until_the_geometry_changes():
    first = signed_distance.cached_field(box(), FREE)
    first.at(some_points(100))
    before = first.memory
    assert signed_distance.cached_field(box().copy(), FREE) is first
    first.at(some_points(100))
    assert first.memory == before
    assert signed_distance.cached_field(box(high=HIGH + 1e-3), FREE) is not first


def test_a_scene_without_triangles_has_no_inside():
    distance, slope = signed_distance.cached_field(np.zeros((0, 3, 3)), FREE).at(some_points(10))
    np.testing.assert_array_equal(distance, BAND)
    assert not slope.any()


def test_orientation_keeps_consistent_meshes():
    np.testing.assert_array_equal(orientation.orient_outward(box()), box())
    np.testing.assert_array_equal(orientation.orient_outward(box()[:, ::-1]), box())
    sheet = box()[:2]
    np.testing.assert_array_equal(orientation.orient_outward(sheet), sheet)


@pytest.mark.parametrize("floor", [None, 0.0])
def test_the_bottom_of_a_crate_on_the_floor_is_ignored(floor):
    crate = box([-0.3, 0.0, -0.3], [0.3, 0.8, 0.3])
    slab = box([-2, -0.2, -2], [2, 0.0, 2])
    mesh = crate if floor is not None else np.concatenate([crate, slab])
    points = np.array([[0.2, 0.03, 0.0], [0.2, -0.03, 0.0], [0.5, -0.05, 0.5]])
    found, slope = signed_distance.cached_field(mesh, FREE, floor).at(points)
    np.testing.assert_allclose(found, [-0.1, -0.104, -0.05], atol=0.75 * CELL)
    assert slope[0, 0] > 0.7 and slope[2, 1] > 0.9


def plane(half):
    a, b, c, d = np.array([(-half, 0, -half), (half, 0, -half), (half, 0, half), (-half, 0, half)], float)
    return np.array([(a, c, b), (a, d, c)])


@pytest.mark.parametrize(
    ("half", "far"),
    [(1000.0, []), (250.0, [box((x, 0.0, 20.0), (x + 20.0, 90.0, 40.0)) for x in range(-200, 200, 40)])],
    ids=["a ground of 2 km", "a city of 500 m"],
)
def test_a_large_scene_is_as_exact_as_the_small_room(half, far):
    bench = np.concatenate(
        [box((-0.7, 0.4, -1.2), (0.7, 0.45, -0.8)), box((-0.6, 0.0, -1.2), (-0.5, 0.4, -0.8))]
    )
    rng = np.random.default_rng(0)
    points, free = rng.uniform((-1, -0.1, -1.5), (1, 0.6, 0), (800, 3)), rng.uniform(0.8, 1.2, (20, 3))
    small, large = (
        signed_distance.cached_field(np.concatenate([bench, *parts]), free)
        for parts in ([plane(4.0)], [plane(half), *far])
    )
    np.testing.assert_allclose(large.at(points)[0], small.at(points)[0], atol=1e-9)
    assert large.memory < 2 * small.memory
