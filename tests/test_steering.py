"""The planned path that a rollout follows along its route."""

from types import SimpleNamespace

import numpy as np
import pytest
import torch
from samp_blender.samp_addon.motion import Goal
from samp_blender.samp_addon.synthesis import steering
from samp_blender.samp_addon.synthesis.route import Route


def taken(action="walk", travelled=0.0, speed=0.0, direction=(0.0, 0, 1), end=(0.0, 0, 5.0)):
    """A take on a straight way of 5 m along +Z, or to ``end``."""
    goal = Goal(np.array(end, float), np.array(direction, float), action)
    return SimpleNamespace(
        route=Route(np.zeros(3), np.zeros((0, 3)), goal, action),
        travelled=travelled,
        drive=speed,
        pace=1.2,
        risen=1.0,
    )


def test_who_stands_sets_off_gently_and_reaches_the_pace():
    standing, walking = (steering.plan(taken(speed=v), np.zeros(3)) for v in (0.0, 1.2))
    steps = np.diff(standing[:, 1], prepend=0.0)
    assert (np.diff(steps) >= -1e-9).all() and steps[0] < 0.1
    assert walking[-1, 1] == pytest.approx(1.2, abs=0.01) and standing[-1, 1] < 1.0
    assert np.allclose(walking[:, [0, 2]], 0)


def test_who_faces_away_turns_before_walking_off():
    path = steering.plan(taken(), np.array([0.0, 0.0, np.radians(170)]))
    assert path[-1, 1] < 0.3
    turned = np.degrees(170 * np.pi / 180 - path[:, 2])
    assert (np.diff(turned) > 0).all() and 100 < turned[-1] <= 150 + 1e-6


def test_who_still_sits_does_not_walk_off():
    take = taken()
    take.risen = 0.15
    assert steering.plan(take, np.zeros(3))[-1, 1] < 0.25


@pytest.mark.parametrize("aside", [0.3, -0.2])
def test_who_is_beside_the_way_comes_back_to_it(aside):
    path = steering.plan(taken(travelled=1.0, speed=1.2), np.array([aside, 1.0, 0.0]))
    assert (np.diff(np.abs(path[:, 0])) < 0).all() and abs(path[-1, 0]) < 0.25 * abs(aside)


def test_a_walk_slows_down_and_ends_facing_its_goal():
    path = steering.plan(taken(travelled=4.6, speed=0.8, direction=(1.0, 0, 0)), np.array([0.0, 4.6, 0.0]))
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
    path = steering.follow([take], future, torch.tensor([[0.0, travelled, 0.0]]))
    assert torch.equal(path, future) != follows
