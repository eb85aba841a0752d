"""Phases and steps of a take are found where they are; trails show where feet stand and slide."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import recordings
from samp_blender.samp_addon.edits import marks
from samp_blender.samp_addon.edits.trails import PELVIS, RED, STANDS, SWINGS, trails
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.vocabulary import ACTIONS


def rests(*parts):
    """A motion whose pelvis moves (True) or not, with an action in each part: (action, frames, moves)."""
    steps, weights = [], []
    for action, frames, moves in parts:
        steps += [0.03 if moves else 0.0] * frames
        weights += [np.eye(len(ACTIONS))[ACTIONS.index(action)]] * frames
    root = np.zeros((len(steps), 3))
    root[:, 2], root[:, 1] = np.cumsum(steps), 0.95
    rotations = np.zeros((len(steps), 22, 4))
    rotations[..., 0] = 1
    return Motion(root, rotations, actions=np.array(weights))


WALK, DOWN, REST, UP = ("walk", 40, True), ("sit", 20, True), ("sit", 30, False), ("sit", 15, True)


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        ([WALK], [(0, "Walk")]),
        ([WALK, DOWN, REST], [(0, "Walk"), (40, "Sit Down"), (60, "Hold")]),
        ([REST, UP, WALK], [(0, "Sit Down"), (0, "Hold"), (30, "Stand Up"), (45, "Walk")]),
        (
            [WALK, ("lie", 20, True), ("lie", 30, False), ("lie", 15, True), WALK],
            [(0, "Walk"), (40, "Lie Down"), (60, "Hold"), (90, "Stand Up"), (105, "Walk")],
        ),
    ],
)
def test_phases(parts, expected):
    found = marks.phases(rests(*parts))
    assert [name for _, name in found] == [name for _, name in expected]
    assert np.abs(np.subtract([f for f, _ in found], [f for f, _ in expected])).max() <= 1


def test_steps_of_a_walk():
    found = marks.steps(recordings.walk(120))  # a step of each foot in 24 frames
    for side in ("Left", "Right"):
        frames = [frame for frame, name in found if name == f"{side} Step"]
        assert 3 <= len(frames) <= 5 and np.abs(np.diff(frames) - 24).max() <= 3


def test_trails_of_a_walk_are_green_where_feet_stand_and_red_where_they_slide():
    walk = recordings.walk(120)
    found = trails(walk)
    assert found.points.shape == (3 * 119, 2, 3) and found.colours.shape == (3 * 119, 4)
    np.testing.assert_array_equal(found.points[0], walk.root[:2])
    assert (found.colours[:119] == PELVIS).all()
    feet = found.colours[119:]
    shares = {
        name: (feet == colour).all(-1).mean() for name, colour in (("stands", STANDS), ("swings", SWINGS))
    }
    assert shares["stands"] > 0.35 and shares["swings"] > 0.2
    assert (feet == RED).all(-1).mean() < 0.1 and not found.slides.any() and len(found.stands) >= 8
    drift = walk.root + np.linspace(0, 1, 120)[:, None] * [1.2, 0, 0]  # 30 cm/s to the side
    sliding = trails(replace(walk, root=drift))
    assert (sliding.colours[119:] == RED).all(-1).mean() > 0.2 and sliding.slides.mean() > 0.7


def test_a_single_frame_has_no_trails():
    assert len(trails(recordings.walk(1)).points) == 0
