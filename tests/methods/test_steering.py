"""The planned path that a rollout follows along its route."""

import numpy as np
import pytest
import torch
from samp_blender.samp_addon.methods.samp.request import Request
from samp_blender.samp_addon.methods.samp.rollout import steering, tracking
from samp_blender.samp_addon.methods.samp.rollout.tracking import Observation, RolloutProgress
from samp_blender.samp_addon.methods.samp.route import Route
from samp_blender.samp_addon.motion import Goal


def taken(action="walk", travelled=0.0, speed=0.0, direction=(0.0, 0, 1), end=(0.0, 0, 5.0)):
    """Progress of a take on a straight route of 5 m along +Z, or to ``end``."""
    goal = Goal(np.array(end, float), np.array(direction, float), action)
    route = Route(np.zeros(3), np.zeros((0, 3)), goal, action)
    tracked = RolloutProgress([Request(np.zeros(3), 0.0, action, goal)], [route])
    tracked.travelled, tracked.planned_speed, tracked.pace = (
        np.array([travelled]),
        np.array([speed]),
        np.array([1.2]),
    )
    return tracked


def plan(tracked, root):
    return steering.plan(tracked, np.asarray(root, dtype=np.float64)[None])[0]


def test_the_planned_path_accelerates_gently_to_the_pace():
    standing, walking = (plan(taken(speed=v), np.zeros(3)) for v in (0.0, 1.2))
    steps = np.diff(standing[:, 1], prepend=0.0)
    assert (np.diff(steps) >= -1e-9).all() and steps[0] < 0.1
    assert walking[-1, 1] == pytest.approx(1.2, abs=0.01) and standing[-1, 1] < 1.0
    assert np.allclose(walking[:, [0, 2]], 0)


def test_bodies_that_face_away_turn_before_they_set_off():
    path = plan(taken(), np.array([0.0, 0.0, np.radians(170)]))
    assert path[-1, 1] < 0.3
    turned = np.degrees(170 * np.pi / 180 - path[:, 2])
    assert (np.diff(turned) > 0).all() and 80 < turned[-1] <= np.degrees(steering.TURNING) + 1e-6


def test_a_body_that_hesitates_is_led_on():
    """The network does not always turn: the longer it takes, the farther the plan leads, and not for ever."""
    away, reached = np.array([0.0, 0.0, np.radians(170)]), []
    for seconds in (0.0, steering.PATIENCE, 2.5, 4.0, 9.0):
        take = taken(speed=1.0)
        take.hesitated = np.array([seconds])
        reached.append(plan(take, away)[-1, 1])
    assert reached[0] == reached[1] < reached[2] < reached[3] == reached[4] < 0.8


@pytest.mark.parametrize(
    ("speed", "height", "travelled", "hesitates"),
    [(0.1, 0.93, 0.0, True), (0.8, 0.93, 0.0, False), (0.1, 0.6, 0.0, False), (0.1, 0.93, 4.6, False)],
    ids=["stands", "walks", "sits", "has arrived"],
)
def test_who_hesitates(speed, height, travelled, hesitates):
    take = taken(travelled=travelled)
    place = np.array([[0.0, height, travelled]])
    number = lambda value: np.array([value])
    seen = Observation(place[:, [0, 2]], place, number(speed), number(0.0), np.eye(5)[:1], number(1.0))
    for frame in range(15):
        take.update(seen, frame)
    assert take.hesitated[0] == pytest.approx(0.5 * hesitates)


def test_seated_bodies_do_not_set_off():
    take = taken()
    take.rise = np.array([0.15])
    assert plan(take, np.zeros(3))[-1, 1] < 0.25


@pytest.mark.parametrize("aside", [0.3, -0.2])
def test_the_planned_path_returns_to_the_route(aside):
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
def test_the_last_steps_to_a_seat_are_left_to_the_network(action, travelled, follows):
    take = taken(action, travelled, 1.0)
    future = torch.full((1, steering.FUTURE, 3), 0.3)
    path = steering.Guide(take).follow(future, torch.tensor([[0.0, travelled, 0.0]]))
    assert torch.equal(path, future) != follows


def observed(tracked, place=(0.0, 0.6, 5.0), speed=0.0, weight=1.0):
    """Observation of an upright body at a place (3,), with this weight of its action."""
    weights = np.zeros((1, 5))
    weights[0, tracked.action] = weight
    place = np.array([place])
    return Observation(place[:, [0, 2]], place, np.array([speed]), np.zeros(1), weights, np.ones(1))


@pytest.mark.parametrize(
    "place, speed, weight, sits",
    [
        ((0.0, 0.6, 5.0), 0.0, 1.0, True),
        ((0.0, 0.9, 4.8), 0.0, 1.0, False),  # stands still in front of the seat
        ((0.0, 0.6, 4.6), 0.0, 1.0, False),
        ((0.0, 0.6, 5.0), 0.5, 1.0, False),
        ((0.0, 0.6, 5.0), 0.0, 0.4, False),
    ],
)
def test_sitting_is_told_by_place_speed_and_weight(place, speed, weight, sits):
    tracked = taken("sit", travelled=4.5, end=(0.0, 0.55, 5.0))
    tracked.update(observed(tracked, place, speed, weight), frame=100)
    assert tracked.held[0] == sits


def test_a_body_that_sits_off_its_goal_is_stuck():
    """The take ends long before its frame limit."""
    tracked = taken("sit", travelled=4.5, end=(0.0, 0.55, 5.0))
    for frame in range(200):
        tracked.update(observed(tracked, (0.4, 0.6, 5.0)), frame)
        if tracked.ended(frame)[0]:
            break
    assert frame + 1 == steering.FPS * tracking.OFF_GOAL < tracked.limit[0]
    assert (tracked.held[0], tracked.done_at[0]) == (0, -1)


def test_once_arrived_the_target_action_is_held():
    """Before, future actions are the network's; a take ends when its action was held for long enough."""
    tracked = taken("sit", travelled=4.5, end=(0.0, 0.55, 5.0))
    predicted = torch.full((1, steering.FUTURE, 5), 0.2)
    assert torch.equal(steering.Guide(tracked).intend(predicted), predicted)
    for frame in range(200):
        tracked.update(observed(tracked), frame)
        if tracked.ended(frame)[0]:
            break
    assert tracked.held[0] == tracked.hold[0] == frame + 1 == 60
    assert torch.equal(steering.Guide(tracked).intend(predicted)[0, 0], torch.eye(5)[3])


def test_selected_takes_are_planned_as_in_the_whole_batch():
    requests = [
        Request(np.zeros(3), 0.0, "walk", Goal(np.array([x, 0.0, 5.0]), np.array([0, 0, 1.0]), "walk"))
        for x in (-1.0, 0.0, 1.0)
    ]
    tracked = RolloutProgress(
        requests, [Route(np.zeros(3), np.zeros((0, 3)), r.goal, "walk") for r in requests]
    )
    rows = np.array([0, 2])
    part = tracked.select(rows)
    roots = np.array([[0.1, 0.4, 0.2]] * 3)
    np.testing.assert_array_equal(steering.plan(part, roots[rows]), steering.plan(tracked, roots)[rows])
    np.testing.assert_array_equal(part.goals(), tracked.goals()[rows])


@pytest.mark.parametrize("away, height, follows", [(0.6, 0.9, False), (1.0, 0.9, True), (1.0, 0.7, False)])
def test_walkers_that_overshoot_the_seat_are_steered_back(away, height, follows):
    tracked = taken("sit", travelled=5.0, end=(0.0, 0.55, 5.0))
    root = np.array([away, tracked.routes.points[0, -1, 1]])
    tracked.update(observed(tracked, (root[0], height, root[1]), weight=0.0), frame=100)
    future = torch.full((1, steering.FUTURE, 3), 0.3)
    path = steering.Guide(tracked).follow(future, torch.tensor([[root[0], root[1], 0.0]]))
    assert torch.equal(path, future) != follows
    if follows:
        assert abs(float(path[0, -1, 0])) < away / 2


@pytest.mark.parametrize(
    "postures, upright, held",
    [((), 0.75, 0), ((), 0.4, 1), (("half_sitting",), 0.75, 1), (("half_sitting",), 0.97, 0)],
)
def test_half_sitting_bodies_need_not_lie_flat(postures, upright, held):
    goal = Goal(np.array([0.0, 0.55, 5.0]), np.array([0.0, 0, 1]), "lie")
    route = Route(np.zeros(3), np.zeros((0, 3)), goal, "lie")
    tracked = RolloutProgress([Request(np.zeros(3), 0.0, "lie", goal)], [route], [postures])
    tracked.travelled = np.array([route.length])
    weights = np.eye(5)[[4]]
    still = np.zeros(1)
    pelvis = np.array([[0.0, 0.55, 5.0]])
    tracked.update(
        Observation(pelvis[:, [0, 2]], pelvis, still, still, weights, np.array([upright])), frame=100
    )
    assert tracked.held[0] == held
