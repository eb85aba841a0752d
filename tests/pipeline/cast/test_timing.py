"""When the members of a cast set off: bodies as single balls that move along lines."""

from __future__ import annotations

import numpy as np
import pytest
from samp_blender.samp_addon.body.balls import Track
from samp_blender.samp_addon.evaluation.between_bodies import conflicts, depth, over_time
from samp_blender.samp_addon.pipeline.cast.timing import pairs, pause, schedule

RADIUS = 0.25
LIMIT = 200


def along(*points, speed=0.12, hold=0):
    """A ball that moves along points (x, z) at metres a frame, and stays at the last one for some frames."""
    line = [points[0]]
    for a, b in zip(points[:-1], points[1:], strict=True):
        steps = max(int(np.linalg.norm(np.subtract(b, a)) / speed), 1)
        line += [tuple(np.add(a, np.subtract(b, a) * k / steps)) for k in range(1, steps + 1)]
    line += [points[-1]] * hold
    return Track(np.array([[[x, 1.0, z]] for x, z in line]), np.array([RADIUS]), 10.0)


def met(tracks, starts):
    """How deep two of the bodies are in each other at most while they follow a schedule."""
    end = max(start + len(track) for start, track in zip(starts, tracks, strict=True))
    rows = [np.clip(np.arange(end) - s, 0, len(t) - 1) for s, t in zip(starts, tracks, strict=True)]
    return max(
        depth(tracks[a], tracks[b], rows[a], rows[b]).max() for b in range(len(tracks)) for a in range(b)
    )


DOOR = (0.0, 0.0)
THROUGH = {
    "apart": ([along((-3, 0), (3, 0)), along((-3, 2), (3, 2))], [0, 0]),
    "crossing": ([along((-3, 0), (3, 0)), along((0, -3), (0, 3))], [0, 0]),
    "door against each other": (
        [along((-2, -3), DOOR, (2, 3)), along((3, 3), DOOR, (-3, -3))],
        [0, 0],
    ),
    "behind each other": ([along((-2, 0), (3, 0)), along((-3, 0), (2, 0))], [0, 0]),
    "one starts in the other's way": ([along((-3, 0), (3, 0)), along((0, 0), (0, 3))], [0, 0]),
    "three through a door": (
        [along((-2, -3), DOOR, (2, 3)), along((-1, -3), DOOR, (1, 3)), along((0, -4), DOOR, (0, 3))],
        [0, 0, 0],
    ),
    "the second is asked first": ([along((-3, 0), (3, 0)), along((0, -3), (0, 3))], [30, 0]),
}


@pytest.mark.parametrize("name", THROUGH)
def test_nobody_meets_and_nobody_waits_for_nothing(name):
    tracks, earliest = THROUGH[name]
    made = schedule(pairs(tracks), [len(t) for t in tracks], earliest, LIMIT)
    assert not made.stuck
    assert met(tracks, made.starts) <= 0
    assert all(start >= early for start, early in zip(made.starts, earliest, strict=True))
    if name == "apart":
        assert made.starts == (0, 0)
    if met(tracks, earliest) > 0:
        assert max(np.subtract(made.starts, earliest)) > 0


def test_a_body_that_never_makes_way_leaves_another_stuck():
    tracks = [along((-3, 0), (3, 0)), along((0.3, 0), (0.3, 0.1), hold=5)]
    made = schedule(pairs(tracks), [len(t) for t in tracks], [0, 0], LIMIT, fixed={1: 0})
    assert made.stuck == {0: 1}


def test_fixed_bodies_keep_their_time():
    tracks = [along((-3, 0), (3, 0)), along((0, -3), (0, 3))]
    made = schedule(pairs(tracks), [len(t) for t in tracks], [0, 7], LIMIT, fixed={1: 7})
    assert made.starts[1] == 7
    assert met(tracks, made.starts) <= 0


def test_conflicts_reach_beyond_the_samples():
    one, two = along((-1, 0), (1, 0)), along((0, -1), (0, 1))
    flags = conflicts(one, two, 0.0)
    rows, columns = np.indices(flags.shape)
    deep = depth(one, two, rows.ravel(), columns.ravel()).reshape(flags.shape) > 0
    assert deep.any() and flags[deep].all() and flags.sum() > deep.sum()


def test_depth_over_time_holds_the_last_pose():
    one, two = along((-2, 0), (0, 0)), along((0.4, 0), (0.4, 0.001))
    found = over_time(one, two)
    assert len(found) == len(one)
    assert found[0] == -np.inf
    assert found[-1] == pytest.approx(2 * RADIUS - 0.4, abs=1e-3)


def test_waiting_in_front_of_the_door_instead_of_at_the_start():
    first, second = along((1, -6), (0, -3), (0, 3)), along((0, 8), DOOR, (0, -2), (2, -3))
    tracks = [first, second]
    lengths, known = [len(first), len(second)], pairs(tracks)
    made = schedule(known, lengths, [0, 0], LIMIT)
    assert not made.stuck and max(made.starts) > 0
    late = int(np.argmax(made.starts))
    frame = pause(known, lengths, made.starts, late, 0, lengths[late] - 1)
    assert frame is not None
    rows = np.arange(made.starts[late] + lengths[late])
    own = np.where(rows < frame, rows, np.maximum(frame, rows - made.starts[late]))
    other = np.clip(rows - made.starts[1 - late], 0, lengths[1 - late] - 1)
    assert depth(tracks[late], tracks[1 - late], own, other).max() <= 0
    assert pause(known, lengths, made.starts, 1 - late, 0, 20) is None  # it does not wait at all
