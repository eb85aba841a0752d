"""Surfaces and the interaction grid."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from samp_blender.samp_addon import frames
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.scene import geometry, voxels
from samp_blender.samp_addon.scene.voxels import InteractionGrid
from samp_blender.tests.support import layouts

FURNITURE = Path(__file__).parents[3] / "shared" / "data" / "furniture"


def exact_distance(points, triangles):
    """Brute force: each point (N, 3) against every triangle."""
    found = np.empty(len(points))
    for k, point in enumerate(points):
        here = np.broadcast_to(point, (len(triangles), 3))
        found[k] = np.linalg.norm(geometry.closest_points(here, triangles) - here, axis=1).min()
    return found


def test_closest_points_agree_with_dense_samples():
    rng = np.random.default_rng(1)
    triangles, points = rng.normal(size=(40, 3, 3)), rng.normal(size=(40, 3)) * 2
    share = rng.dirichlet((1, 1, 1), 40_000)
    corners = np.concatenate([share, np.eye(3)])
    for triangle, point in zip(triangles, points, strict=True):
        sampled = np.linalg.norm(corners @ triangle - point, axis=1).min()
        found = geometry.closest_points(point[None], triangle[None])[0]
        assert np.linalg.norm(found - point) <= sampled + 1e-9
        assert np.linalg.norm(found - point) >= sampled - 0.05
        solved = np.linalg.lstsq(np.vstack([triangle.T, np.ones(3)]), np.append(found, 1), rcond=None)[0]
        np.testing.assert_allclose(solved @ triangle, found, atol=1e-6)
        assert (solved > -1e-6).all()


@pytest.mark.parametrize("degenerate", [[(0, 0, 0)] * 3, [(0, 0, 0), (1, 0, 0), (2, 0, 0)]])
def test_closest_points_of_degenerate_triangles(degenerate):
    found = geometry.closest_points(np.array([[1.5, 1.0, 0.0]]), np.array([degenerate], dtype=float))
    assert np.linalg.norm(found - [min(1.5, degenerate[2][0]), 0, 0]) < 1e-9


def test_samples_are_uniform_by_area_and_reproducible():
    triangles = np.concatenate([layouts.box((0, 0, 0), (1, 1, 1)), layouts.box((3, 0, 0), (5, 2, 2))])
    points, index = geometry.sample_surface(triangles, 20_000, seed=4)
    assert abs((points[:, 0] > 2).mean() - 0.8) < 0.02
    assert exact_distance(points[:200], triangles).max() < 1e-9
    assert (geometry.sample_surface(triangles, 20_000, seed=4)[0] == points).all()
    assert not (geometry.sample_surface(triangles, 20_000, seed=5)[0] == points).all()
    spread, owner = geometry.spread_over_surface(triangles, 3000)
    counts = np.bincount(owner, minlength=len(triangles))
    np.testing.assert_allclose(counts / 3000, geometry.areas(triangles) / 30, atol=1e-3)


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.5])
def test_the_grid_rotates_with_the_object(yaw):
    by = np.array([3.0, 0.5, -2.0])
    grid = InteractionGrid.build(layouts.moved(layouts.box((-1, 0, -0.4), (1, 0.8, 0.4)), yaw, by), yaw)
    np.testing.assert_allclose(grid.size, (2, 0.8, 0.8), atol=1e-9)
    np.testing.assert_allclose(grid.centre, by + [0, 0.4, 0], atol=1e-9)
    forward = grid.centres.reshape(8, 8, 8, 3)[0, 0]
    np.testing.assert_allclose((forward[1] - forward[0]) / 0.1, frames.yaw_direction(yaw), atol=1e-9)
    straight = InteractionGrid.build(layouts.box((-1, 0, -0.4), (1, 0.8, 0.4)), 0.0)
    np.testing.assert_allclose(grid.occupancy, straight.occupancy, atol=1e-6)


def test_occupancy_is_one_minus_the_distance_in_cells():
    grid = InteractionGrid.build(layouts.box((0, 0, 0), (1.6, 0.8, 0.8)))
    distance = exact_distance(grid.centres, layouts.box((0, 0, 0), (1.6, 0.8, 0.8)))
    np.testing.assert_allclose(grid.occupancy, np.maximum(0, 1 - distance / 0.2), atol=1e-6)
    assert grid.centres.shape == (512, 3) and 0.7 < grid.occupancy.max() < 0.8


@pytest.mark.parametrize("count", [200, 2000, 20_000])
def test_occupancy_of_fine_meshes(count):
    triangles = layouts.ball(count, (0.9, 0.5, 0.6), (0, 0.5, 0))
    grid = InteractionGrid.build(triangles, 0.3)
    some = np.arange(0, 512, max(count // 300, 1))
    exact = np.maximum(0, 1 - exact_distance(grid.centres[some], triangles) / grid.cell_size.max())
    assert np.abs(grid.occupancy[some] - exact).max() < 0.01


def test_features_are_in_the_root_frame():
    grid = InteractionGrid.build(layouts.sofa((2, 1)), 0.0)
    position, yaw = np.array([2.0, 0.93, -1.0]), 0.4
    features = grid.features(position, yaw).reshape(512, 4)
    np.testing.assert_array_equal(features[:, 3], grid.occupancy)
    forward, left = frames.yaw_direction(yaw), frames.yaw_direction(yaw + np.pi / 2)
    offset = grid.centres - [2, 0, -1]
    np.testing.assert_allclose(features[:, 2], offset @ forward, atol=1e-12)
    np.testing.assert_allclose(features[:, 0], offset @ left, atol=1e-12)
    np.testing.assert_allclose(features[:, 1], grid.centres[:, 1], atol=1e-12)
    upstairs = grid.features(position + [0, 3, 0], yaw, floor=3.0).reshape(512, 4)
    np.testing.assert_allclose(upstairs[:, 1], grid.centres[:, 1] - 3, atol=1e-12)


def test_features_of_several_characters():
    grid = InteractionGrid.build(layouts.sofa(), 0.0)
    positions, yaws = np.random.default_rng(0).normal(size=(5, 3)), np.arange(5.0)
    together = grid.features(positions, yaws)
    assert together.shape == (5, voxels.FEATURES)
    for k in range(5):
        np.testing.assert_allclose(together[k], grid.features(positions[k], yaws[k]))


def test_object_features_do_not_depend_on_the_object_s_placement():
    here = InteractionGrid.build(layouts.sofa(), 0.0).object_features()
    there = InteractionGrid.build(layouts.sofa((5, -3), 1.1), 1.1).object_features()
    np.testing.assert_allclose(here, there, atol=1e-6)


@pytest.mark.parametrize(
    ("triangles", "words"),
    [
        (np.zeros((0, 3, 3)), "no faces"),
        (np.full((3, 3, 3), np.nan), "not numbers"),
        (np.full((3, 3, 3), np.inf), "not numbers"),
        (np.zeros((3, 3, 3)), "no area"),
    ],
)
def test_unusable_objects_raise_an_error_that_names_them(triangles, words):
    with pytest.raises(SampError, match=words) as error:
        InteractionGrid.build(triangles, 0.0, "Old Sofa")
    assert "Old Sofa" in str(error.value)


def test_flat_objects_have_a_grid():
    grid = InteractionGrid.build(layouts.floor(2, 1)[4:6], 0.0)
    assert np.isfinite(grid.centres).all() and grid.occupancy.max() > 0.99


def test_scene_geometry_selects_objects_by_name():
    scene = geometry.SceneGeometry.from_objects(
        [("Sofa", layouts.sofa()), ("Nothing", np.zeros((0, 3, 3))), ("Table", layouts.table((4, 0)))]
    )
    assert len(scene.triangles_of(["Sofa"])) == 24 and len(scene.triangles_of(["Nothing"])) == 0
    assert len(scene.without(["Sofa"])) == len(layouts.table())
    np.testing.assert_allclose(scene.bounds[1], (4.8, 0.9, 0.45))
    with pytest.raises(SampError, match="no faces"):
        geometry.SceneGeometry().bounds  # noqa: B018
    with pytest.raises(SampError, match="Lamp"):
        geometry.SceneGeometry.from_objects([("Lamp", np.full((1, 3, 3), np.nan))])


@pytest.mark.skipif(not FURNITURE.exists(), reason="the furniture files are not available")
@pytest.mark.parametrize("kind", ["armchair", "bed", "chair", "sofa", "stool"])
def test_real_furniture(kind):
    from samp_blender.training.furniture import library

    path = sorted(FURNITURE.glob(f"{kind}_*.glb"))[0]
    grid = InteractionGrid.build(library.read_glb(path), 0.0, path.stem)
    assert np.isfinite(grid.centres).all() and grid.occupancy.min() >= 0 and grid.occupancy.max() <= 1
    assert (grid.occupancy > 0).mean() > 0.2


@pytest.mark.parametrize("yaw", [0.0, 0.7, 2.4])
def test_a_grid_around_a_goal_moves_and_turns_with_it(yaw):
    """A goal on a sofa that is moved, turned and raised with its floor sees the same cells."""
    c, s = np.cos(yaw), np.sin(yaw)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    here = InteractionGrid.around(layouts.sofa(), np.array([0.3, 0.5, 0.0]), 0.2)
    place = turn @ [0.3, 0.5, 0.0] + [2.0, 1.0, -1.0]
    there = InteractionGrid.around(layouts.sofa() @ turn.T + [2.0, 1.0, -1.0], place, 0.2 + yaw, floor=1.0)
    np.testing.assert_allclose(here.occupancy, there.occupancy, atol=1e-6)
    np.testing.assert_allclose(
        (here.centres - [0.3, 0, 0]) @ turn.T, there.centres - place + [0, 0.5, 0], atol=1e-6
    )
    assert 0.9 < here.occupancy.max() <= 1 and here.size == pytest.approx([1.4, 1.4, 1.8])


def test_a_grid_around_a_goal_far_from_the_object_is_empty():
    grid = InteractionGrid.around(layouts.sofa(), np.array([9.0, 0.5, 9.0]), 0.0)
    assert not grid.occupancy.any() and np.isfinite(grid.centres).all()
