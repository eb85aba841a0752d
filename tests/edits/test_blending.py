"""A take and another motion become one, aligned where they meet, with feet that stand."""

from __future__ import annotations

import numpy as np
import pytest
import recordings
from samp_blender.samp_addon.edits.blending import blended
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.refine.feet.plan import plan_feet
from samp_blender.samp_addon.refine.proportions.footprints import Footprints


def slide(motion, rows):
    """Metres per second of standing balls, mean."""
    joints = motion.forward_kinematics()[0]
    found = []
    for plan in plan_feet(motion, Footprints.of(motion)):
        speed = np.linalg.norm(np.gradient(joints[:, plan.foot.ball], 1 / 30, axis=0)[:, [0, 2]], axis=-1)
        found.append(speed[rows][plan.standing[rows]])
    return float(np.concatenate(found).mean())


@pytest.mark.parametrize("moves_before", [False, True])
@pytest.mark.parametrize("turn", [0.0, 1.2])
def test_place_and_facing_are_aligned_and_feet_stand(moves_before, turn):
    before, after = recordings.walk(90), recordings.walk(96, turn=turn)
    made = blended(before, after, 12, moves_before)
    motion = made.motion
    assert len(motion) == 90 + 96 - 12 and (made.first, made.last) == (78, 89)
    speed = np.linalg.norm(np.diff(motion.root, axis=0), axis=-1) * 30
    assert speed.max() < 1.5 and speed[70:100].min() > 0.8  # walks of 1.1 m/s
    facing = motion.headings()
    assert (facing[1:] * facing[:-1]).sum(-1).min() > np.cos(np.radians(6))
    unmoved, part = (after, motion.root[-60:]) if moves_before else (before, motion.root[:60])
    own = unmoved.root[-60:] if moves_before else unmoved.root[:60]
    np.testing.assert_allclose(part, own, atol=1e-9)
    assert slide(motion, slice(70, 98)) < 0.06


@pytest.mark.parametrize("count", [0, 40])
def test_a_blend_longer_than_a_motion_is_refused(count):
    with pytest.raises(SampError, match="choose from 1 to 39"):
        blended(recordings.walk(90), recordings.walk(40), count)
