"""Flights of stairs found on a path: their risers, treads and ground."""

from __future__ import annotations

import numpy as np
import pytest
from layouts import box, floor, moved, ramp, stairs
from samp_blender.samp_addon.scene import flights

RUN = 0.28


def path(*points):
    return np.array(points, dtype=float)


def storeys(steps, rise, run=RUN):
    """Return a floor, stairs and a floor above, and the path over them along +Z."""
    top, end = steps * rise, steps * run
    scene = np.concatenate(
        [floor(), stairs(steps, rise, run), box((-3, top - 0.1, end - run), (3, top, end + 3))]
    )
    return scene, path((0, 0, -2), (0, 0, -0.1), (0, top, end - run + 0.1), (0, top, end + 2))


@pytest.mark.parametrize("down", [False, True], ids=["up", "down"])
@pytest.mark.parametrize(("steps", "rise"), [(2, 0.12), (6, 0.17), (14, 0.22)])
@pytest.mark.parametrize("yaw", [0.0, 0.7])
def test_all_risers_of_a_flight_are_found(steps, rise, down, yaw):
    scene, way = storeys(steps, rise)
    way = moved(way[:, None], yaw)[:, 0]
    (found,) = flights.find(way[::-1] if down else way, moved(scene, yaw))
    treads = np.arange(steps + 1) * rise
    np.testing.assert_allclose(found.treads, treads[::-1] if down else treads, atol=1e-6)
    np.testing.assert_allclose(found.risers, np.arange(steps) * RUN, atol=0.03)
    sign = -1 if down else 1
    np.testing.assert_allclose(found.direction, sign * np.array([np.sin(yaw), 0, np.cos(yaw)]), atol=1e-6)
    assert found.end - found.begin == pytest.approx(found.length)
    beside = found.origin + np.array([[-0.1], [RUN / 2]]) * found.direction
    np.testing.assert_allclose(found.heights(beside), found.treads[:2], atol=1e-6)


@pytest.mark.parametrize(
    ("scene", "way"),
    [
        (floor(), path((0, 0, -2), (0, 0, 2))),
        (np.concatenate([floor(), ramp(25, 0.8)]), path((0, 0, -1), (0, 0, 0), (0, 0.8, 1.8), (0, 0.8, 3))),
        (np.concatenate([floor(), box((-1, 0, 0), (1, 0.05, 3))]), path((0, 0, -2), (0, 0.05, 2))),
        (np.concatenate([floor(), box((-1, 0, 0), (1, 0.33, 3))]), path((0, 0, -2), (0, 0.33, 2))),
        (np.zeros((0, 3, 3)), path((0, 0, -2), (0, 1, 2))),
        (floor(), path((0, 0, 0))),
    ],
    ids=["flat", "ramp", "sill", "too high", "nothing", "a point"],
)
def test_other_ground_has_no_flights(scene, way):
    assert flights.find(way, scene) == []


def test_flights_around_a_landing_are_two():
    """Up along +Z, a landing, and up along +X."""
    first, second = stairs(4, 0.17), moved(stairs(4, 0.17), np.pi / 2, (1.0, 0.68, 4 * RUN + 0.6))
    landing = box((-1, 0.58, 4 * RUN - 0.01), (1.0, 0.68, 4 * RUN + 1.2))
    top = box((1 + 4 * RUN, 1.26, 1), (5, 1.36, 4))
    turn = 4 * RUN + 0.6
    way = path((0, 0, -1.5), (0, 0, 0), (0, 0.68, turn), (1, 0.68, turn), (2.2, 1.36, turn), (4, 1.36, turn))
    found = flights.find(way, np.concatenate([floor(), first, landing, second, top]))
    assert [len(one.risers) for one in found] == [4, 4]
    assert found[0].end < found[1].begin
    np.testing.assert_allclose([one.direction for one in found], [[0, 0, 1], [1, 0, 0]], atol=1e-6)


def test_boards_have_an_upper_face():
    """Open stairs of thin boards."""
    boards = [box((-0.6, 0.18 * k + 0.14, RUN * k), (0.6, 0.18 * (k + 1), RUN * (k + 1))) for k in range(5)]
    scene = np.concatenate([floor(), *boards, box((-2, 0.8, 5 * RUN), (2, 0.9, 5))])
    (found,) = flights.find(path((0, 0, -2), (0, 0, 0), (0, 0.9, 4 * RUN), (0, 0.9, 3)), scene)
    np.testing.assert_allclose(found.treads, np.arange(6) * 0.18, atol=1e-6)
