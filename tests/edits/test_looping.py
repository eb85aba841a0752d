"""Cycles of a walk: two steps, closed, straight, in place or on the way."""

import numpy as np
import pytest
import recordings
from samp_blender.samp_addon import rotation
from samp_blender.samp_addon.edits import looping
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.motion import Motion


@pytest.mark.parametrize("turn", [0.0, 2.0])
@pytest.mark.parametrize("in_place", [False, True])
def test_a_walk_repeats_without_a_jump(turn, in_place):
    made = looping.looped(recordings.walk(150, turn=turn), in_place)
    cycle = made.motion
    assert (len(cycle) - 1) % 24 == 0, "a step of the walk takes 24 frames"
    np.testing.assert_array_equal(cycle.rotations[0], cycle.rotations[-1])
    np.testing.assert_allclose(cycle.root[-1] - cycle.root[0], made.advance, atol=1e-12)
    distance = 0.0 if in_place else 1.1 * (len(cycle) - 1) / 30
    assert np.linalg.norm(made.advance) == pytest.approx(distance, abs=0.02)
    joints = cycle.forward_kinematics()[0]
    twice = np.concatenate([joints, joints[1:] + made.advance])
    jumps = np.linalg.norm(np.diff(twice, n=3, axis=0), axis=-1).max(1)
    seam = slice(len(cycle) - 4, len(cycle) + 1)
    assert jumps[seam].max() <= 1.5 * np.delete(jumps, np.arange(len(jumps))[seam]).max()


def test_a_curved_walk_goes_on_straight():
    walk = recordings.walk(150)
    turn = rotation.about_y(np.linspace(0, 0.6, 150))
    steps = np.diff(walk.root, axis=0, prepend=walk.root[:1])
    rotations = walk.rotations.copy()
    rotations[:, 0] = rotation.multiply(turn, rotations[:, 0])
    made = looping.looped(Motion(walk.root[0] + np.cumsum(rotation.rotate(turn, steps), 0), rotations))
    np.testing.assert_allclose(made.motion.headings()[0], made.motion.headings()[-1], atol=1e-9)


def test_what_does_not_repeat():
    walk = recordings.walk(20)
    with pytest.raises(SampError, match="Nothing in this take repeats"):
        looping.looped(walk)
