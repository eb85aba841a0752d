"""A new end goes on with the speed of the beginning, and gets to where it was."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import recordings
from samp_blender.samp_addon.edits.continuation import continued


@pytest.mark.parametrize("slower", [0.4, 0.8])
def test_the_speed_changes_gradually_and_the_end_stays(slower):
    walk = recordings.walk(150)
    head, rest = walk.at_frames(np.arange(60)), walk.at_frames(np.arange(59, 150))
    brake = np.clip(np.arange(91) / 6, 0, 1)  # the new end begins slowly
    root = rest.root.copy()
    root[:, 2] = root[0, 2] + np.cumsum(
        np.diff(rest.root[:, 2], prepend=rest.root[0, 2]) * (slower + (1 - slower) * brake)
    )
    tail = replace(rest, root=root)
    made = continued(head, tail)
    speed = lambda motion: np.diff(np.concatenate([head.root[-2:-1], motion.root])[:, 2]) * 30
    assert abs(speed(made)[1] - speed(made)[0]) < 0.35 * abs(speed(tail)[1] - speed(tail)[0]) + 0.08
    np.testing.assert_array_equal(made.root[0], tail.root[0])
    np.testing.assert_allclose(made.root[60:], tail.root[60:], atol=1e-9)
    np.testing.assert_allclose(made.rotations[60:, :22], tail.rotations[60:], atol=1e-9)
    assert np.ptp(made.rotations[:, 22:], axis=0).max() == 0  # hands and face need a single key


def test_what_goes_on_already_hardly_changes():
    walk = recordings.walk(120)
    tail = walk.at_frames(np.arange(59, 120))
    made = continued(walk.at_frames(np.arange(60)), tail)
    assert np.abs(made.root - tail.root).max() < 0.02
    joints, before = (motion.forward_kinematics()[0][:, :22] for motion in (made, tail))
    assert np.linalg.norm(joints - before, axis=-1).max() < 0.06


def test_a_single_frame_goes_on_as_it_is():
    walk = recordings.walk(30)
    made = continued(walk.at_frames(np.arange(1)), walk)
    np.testing.assert_array_equal(made.root, walk.root)
