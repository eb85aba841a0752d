"""Members of a cast get places that are apart, as many as there can be, the near and good ones."""

from __future__ import annotations

import numpy as np
import pytest
from samp_blender.samp_addon.motion import Goal
from samp_blender.samp_addon.pipeline.cast.assignment import APART, Place, assign, spread


def place(x, z=0.0, piece=0, score=0.8):
    return Place(piece, Goal(np.array([x, 0.5, z]), np.array([0.0, 0.0, 1.0]), "sit"), score)


BENCH = [place(x) for x in (-0.6, -0.3, 0.0, 0.3, 0.6)]
CHAIRS = [place(2.0 * k, piece=k) for k in range(4)]
START = np.array([0.0, 0.0, 3.0])


@pytest.mark.parametrize(
    ("xs", "count", "found"),
    [
        ((0.0, 0.3, 0.6), 2, {0.0, 0.6}),
        ((0.0, 0.3, 0.6), 3, {0.0, 0.6}),
        ((0.0, 0.3, 0.6), 1, {0.0}),
        ((), 2, set()),
        ((0.0, 0.5, 0.6, 1.2), 3, {0.0, 0.6, 1.2}),
    ],
)
def test_spread(xs, count, found):
    points = np.array([[x, 0.5, 0.0] for x in xs]).reshape(-1, 3)
    scores = np.linspace(1.0, 0.9, len(xs))
    assert {xs[k] for k in spread(points, scores, count, APART["sit"])} == found


@pytest.mark.parametrize(("members", "seated"), [(1, 1), (2, 2), (3, 3), (4, 3)])
def test_a_bench_has_room_for_three(members, seated):
    found = assign([START] * members, [[0]] * members, BENCH)
    xs = sorted(each.goal.position[0] for each in found if each is not None)
    assert len(xs) == seated
    assert (np.diff(xs) >= APART["sit"] - 1e-6).all()


def test_each_takes_a_piece_of_its_own_and_the_near_one():
    starts = [np.array([2.0 * k, 0.0, 2.0]) for k in (3, 1, 0, 2)]
    found = assign(starts, [[0, 1, 2, 3]] * 4, CHAIRS)
    assert [each.piece for each in found] == [3, 1, 0, 2]


def test_a_member_keeps_to_its_own_pool():
    found = assign([None, None], [[2], [2, 0]], CHAIRS)
    assert [each.piece for each in found] == [2, 0]


def test_occupied_places_are_not_free():
    found = assign([START] * 3, [[0]] * 3, BENCH, np.array([[-0.55, 0.5, 0.0]]))
    taken = [each.goal.position[0] for each in found if each is not None]
    assert len(taken) == 2 and min(taken) >= -0.1 - 1e-6
    above = assign([START], [[0]], BENCH[:1], np.array([[-0.6, 3.5, 0.0]]))
    assert above[0] is not None  # on another storey


def test_nowhere_to_sit():
    assert assign([START, START], [[0], [0]], []) == [None, None]
