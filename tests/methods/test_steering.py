"""The planned path that a rollout follows along its route."""

import numpy as np
import pytest
import torch
from samp_blender.samp_addon.methods.samp.request import Request
from samp_blender.samp_addon.methods.samp.rollout import steering, tracking
from samp_blender.samp_addon.methods.samp.rollout.tracking import Seen, UnderWay
from samp_blender.samp_addon.methods.samp.route import Route
from samp_blender.samp_addon.motion import Goal


def taken(action="walk", travelled=0.0, speed=0.0, direction=(0.0, 0, 1), end=(0.0, 0, 5.0)):
    """A take on a straight way of 5 m along +Z, or to ``end``."""
    goal = Goal(np.array(end, float), np.array(direction, float), action)
    route = Route(np.zeros(3), np.zeros((0, 3)), goal, action)
    way = UnderWay([Request(np.zeros(3), 0.0, action, goal)], [route])
    way.travelled, way.drive, way.pace = np.array([travelled]), np.array([speed]), np.array([1.2])
    return way


def plan(way, root):
    return steering.plan(way, np.asarray(root, dtype=np.float64)[None])[0]


def test_who_stands_sets_off_gently_and_reaches_the_pace():
    standing, walking = (plan(taken(speed=v), np.zeros(3)) for v in (0.0, 1.2))
    steps = np.diff(standing[:, 1], prepend=0.0)
    assert (np.diff(steps) >= -1e-9).all() and steps[0] < 0.1
    assert walking[-1, 1] == pytest.approx(1.2, abs=0.01) and standing[-1, 1] < 1.0
    assert np.allclose(walking[:, [0, 2]], 0)


def test_who_faces_away_turns_before_walking_off():
    path = plan(taken(), np.array([0.0, 0.0, np.radians(170)]))
    assert path[-1, 1] < 0.3
    turned = np.degrees(170 * np.pi / 180 - path[:, 2])
    assert (np.diff(turned) > 0).all() and 100 < turned[-1] <= 150 + 1e-6


def test_who_still_sits_does_not_walk_off():
    take = taken()
    take.risen = np.array([0.15])
    assert plan(take, np.zeros(3))[-1, 1] < 0.25


@pytest.mark.parametrize("aside", [0.3, -0.2])
def test_who_is_beside_the_way_comes_back_to_it(aside):
    path = plan(taken(travelled=1.0, speed=1.2), np.array([aside, 1.0, 0.0]))
    assert (np.diff(np.abs(path[:, 0])) < 0).all() and abs(path[-1, 0]) < 0.25 * abs(aside)


def test_a_walk_slows_down_and_ends_facing_its_goal():
    path = plan(taken(travelled=4.6, speed=0.8, direction=(1.0, 0, 0)), np.array([0.0, 4.6, 0.0]))
    assert path[:, 1].max() <= 5 + 1e-9 and path[-1, 1] > 4.9
    assert np.degrees(path[-1, 2]) == pytest.approx(90, abs=3)
    steps = np.diff(path[:, 1], prepend=4.6)
    assert steps[-1] < 0.5 * steps[0]


@pytest.mark.parametrize(
    "action, travelled, follows", [("sit", 5.0, False), ("sit", 2.0, True), ("walk", 4.5, True)]
)
def test_the_last_steps_to_a_seat_are_the_networks_own(action, travelled, follows):
    take = taken(action, travelled, 1.0)
    future = torch.full((1, steering.FUTURE, 3), 0.3)
    path = steering.Guide(take).follow(future, torch.tensor([[0.0, travelled, 0.0]]))
    assert torch.equal(path, future) != follows


def seen(way, place=(0.0, 0.6, 5.0), speed=0.0, weight=1.0):
    """A body at a place (3,), its action's weight as given, upright."""
    weights = np.zeros((1, 5))
    weights[0, way.action] = weight
    place = np.array([place])
    return Seen(place[:, [0, 2]], place, np.array([speed]), np.zeros(1), weights, np.ones(1))


@pytest.mark.parametrize(
    "place, speed, weight, sits",
    [
        ((0.0, 0.6, 5.0), 0.0, 1.0, True),
        ((0.0, 0.9, 4.8), 0.0, 1.0, False),  # hesitates in front of the seat
        ((0.0, 0.6, 4.6), 0.0, 1.0, False),
        ((0.0, 0.6, 5.0), 0.5, 1.0, False),
        ((0.0, 0.6, 5.0), 0.0, 0.4, False),
    ],
)
def test_who_counts_as_sitting(place, speed, weight, sits):
    way = taken("sit", travelled=4.5, end=(0.0, 0.55, 5.0))
    way.update(seen(way, place, speed, weight), frame=100)
    assert way.held[0] == sits


def test_who_sits_in_the_air_is_stuck():
    """A way that others would take all the time for is over soon."""
    way = taken("sit", travelled=4.5, end=(0.0, 0.55, 5.0))
    for frame in range(200):
        way.update(seen(way, (0.4, 0.6, 5.0)), frame)
        if way.over(frame)[0]:
            break
    assert frame + 1 == steering.FPS * tracking.BESIDE < way.limit[0]
    assert (way.held[0], way.done_at[0]) == (0, -1)


def test_who_sits_means_to_stay():
    """The others' intentions are the network's; a take is over when it was held for long enough."""
    way = taken("sit", travelled=4.5, end=(0.0, 0.55, 5.0))
    says = torch.full((1, steering.FUTURE, 5), 0.2)
    assert torch.equal(steering.Guide(way).intend(says), says)
    for frame in range(200):
        way.update(seen(way), frame)
        if way.over(frame)[0]:
            break
    assert way.held[0] == way.hold[0] == frame + 1 == 60
    assert torch.equal(steering.Guide(way).intend(says)[0, 0], torch.eye(5)[3])


def test_some_of_the_takes_go_on_as_they_would_together():
    requests = [
        Request(np.zeros(3), 0.0, "walk", Goal(np.array([x, 0.0, 5.0]), np.array([0, 0, 1.0]), "walk"))
        for x in (-1.0, 0.0, 1.0)
    ]
    way = UnderWay(requests, [Route(np.zeros(3), np.zeros((0, 3)), r.goal, "walk") for r in requests])
    rows = np.array([0, 2])
    part = way.only(rows)
    roots = np.array([[0.1, 0.4, 0.2]] * 3)
    np.testing.assert_array_equal(steering.plan(part, roots[rows]), steering.plan(way, roots)[rows])
    np.testing.assert_array_equal(part.goals(), way.goals()[rows])


@pytest.mark.parametrize("away, height, follows", [(0.2, 0.9, False), (0.6, 0.9, True), (0.6, 0.7, False)])
def test_who_walks_past_a_seat_is_led_back_while_standing(away, height, follows):
    way = taken("sit", travelled=5.0, end=(0.0, 0.55, 5.0))
    root = np.array([away, way.routes.points[0, -1, 1]])
    way.update(seen(way, (root[0], height, root[1]), weight=0.0), frame=100)
    future = torch.full((1, steering.FUTURE, 3), 0.3)
    path = steering.Guide(way).follow(future, torch.tensor([[root[0], root[1], 0.0]]))
    assert torch.equal(path, future) != follows
    if follows:
        assert abs(float(path[0, -1, 0])) < away / 2
