"""Long-term: what differs between takes of different seeds, and what does not."""

from dataclasses import replace

import numpy as np
import pytest
import rooms
from samp_blender.samp_addon.methods.long_term import planning, variety
from samp_blender.samp_addon.methods.long_term.sub_goals import bodies, places
from samp_blender.samp_addon.methods.method import Draw
from samp_blender.samp_addon.methods.scene_view import SceneView
from samp_blender.samp_addon.methods.step import Step
from samp_blender.samp_addon.scene.geometry import SceneGeometry
from samp_blender.samp_addon.scene.navmesh import navmesh
from untrained import method

START, END = np.array([-2.0, 0.0, 0.0]), np.array([2.0, 0.0, 0.0])
FLOOR = ((-4, -0.1, -4), (4, 0, 4))


def ground(*boxes):
    return navmesh.build(np.concatenate([rooms.box(*box) for box in (FLOOR, *boxes)]))


def ways(mesh, count=12, scale=1.0):
    line = np.array([START, END])
    return [variety.bowed(mesh, line, np.random.default_rng(seed), scale) for seed in range(count)]


def test_ways_are_bowed_to_both_sides():
    found = ways(ground())
    sides = np.array([way[np.abs(way[:, 2]).argmax(), 2] for way in found])
    assert sides.min() < -0.1 and sides.max() > 0.1 and np.abs(sides).max() <= variety.BOW
    for way in found:
        np.testing.assert_allclose(way[[0, -1]], [START, END])
        first = way[2] - way[0]  # it sets off in the direction of the straight way
        assert abs(first[2]) < 0.15 * first[0]
    for one, other in zip(found, ways(ground()), strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("half", [0.25, 0.4])
def test_ways_keep_off_walls(half):
    walls = [((-1.5, 0, side * half - 0.05), (1.5, 1, side * half + 0.05)) for side in (-1, 1)]
    mesh = ground(*walls)
    for way in ways(mesh):
        numbers = mesh.ground.at(way)
        assert (mesh.pieces.owner[numbers] >= 0).all()
        assert np.abs(way[:, 2]).max() < half - variety.ROOM


def test_short_ways_and_no_noise_leave_the_way():
    mesh, line = ground(), np.array([[0.0, 0, 0], [0.8, 0, 0]])
    assert variety.bowed(mesh, line, np.random.default_rng(0), 1.0) is line
    for way in ways(mesh, 2, 0.0):
        assert np.abs(way[:, 2]).max() < 1e-12


def test_paces_strides_and_pauses_are_near_the_usual_ones():
    rng = np.random.default_rng(0)
    made = [variety.gait(rng, 1.0) for _ in range(200)]
    paces, strides = np.array([[gait.pace, gait.stride] for gait in made]).T
    pauses = [variety.pause(2.0, rng, 1.0) for _ in range(200)]
    for values, share, usual in (
        (paces, variety.PACE, 1), (strides, variety.STRIDE, 1), (pauses, variety.PAUSE, 2),
    ):  # fmt: skip
        off = np.abs(np.array(values) / usual - 1)
        assert 0.6 * share < off.max() <= share
    assert np.corrcoef(paces, strides)[0, 1] > 0.5
    assert variety.pause(0.0, rng, 1.0) == 0.0


def test_one_of_the_best_bodies_is_taken():
    costs = np.array([0.03, 0.0105, 0.02, 0.0085, 0.0124])
    taken = {bodies._near_best(costs, np.random.default_rng(seed)) for seed in range(30)}
    assert taken == {1, 3, 4}


@pytest.fixture(scope="module")
def scene():
    boxes = [FLOOR, ((1.6, 0.3, 1.75), (2.4, 0.45, 2.3)), ((1.6, 0.45, 2.25), (2.4, 0.95, 2.35))]
    geometry = SceneGeometry.from_objects([("room", np.concatenate([rooms.box(*box) for box in boxes]))])
    points = [((0.5, 0.0, -2.5), 0.0), ((2.0, 0.45, 1.95), np.pi), ((-2.0, 0.0, 0.0), 1.0)]
    view = SceneView(geometry, sub_goals=[(np.array(point), yaw) for point, yaw in points])
    tools = method().bodies(view)
    chosen = [tools.draw(tools.place(point, yaw, "Here"), 1, 0.1) for point, yaw in view.sub_goals]
    return replace(view, bodies=chosen)


def test_takes_through_the_same_bodies_differ_by_their_seed_alone(scene):
    step = Step(action="", method="long_term", hold=0.2)
    draw = lambda *seeds: method().generate(
        step, scene, [Draw(seed, seed) for seed in seeds], lambda *_: None
    )[0]
    first, second, again = *draw(4, 5), *draw(4)
    for values in ("root", "rotations", "contacts"):
        np.testing.assert_array_equal(getattr(first.motion, values), getattr(again.motion, values))
    for take in (first, second):
        for passed, body in zip(take.sub_goals, scene.bodies, strict=True):
            np.testing.assert_allclose(passed.position, body.root[0], atol=1e-9)
    assert len(first.motion) != len(second.motion)
    middle = [np.interp(0.0, take.waypoints[:20, 2], take.waypoints[:20, 0]) for take in (first, second)]
    assert abs(middle[0] - middle[1]) > 0.03


def test_places_between_follow_the_bow(scene):
    mesh = scene.navmesh
    stops = [places.Place("idle", point + [0, 0.93, 0], np.pi / 2, point) for point in (START, END)]
    sides = []
    for seed in range(4):
        (leg,) = planning.legs(mesh, stops, np.random.default_rng(seed), 1.0)
        sides.append(leg.stops[0].floor[2])
    assert np.ptp(sides) > 0.05
