"""A pelvis that sinks too deep or too far back while a body sits down."""

from __future__ import annotations

from dataclasses import replace

import bodies
import numpy as np
import pytest
from samp_blender.samp_addon.methods.samp.finishing.seated_pelvis import GIVE, kept_on

GOAL = np.concatenate([[0.0, 0.62, 0.0], [0.0, 0.0, 1.0], np.zeros(5)])


def sitting(away):
    """Return a body whose pelvis comes from the front, is ``away`` (3,) from the goal for a while, and rests on it."""
    motion = bodies.standing(4.0)
    time = np.arange(len(motion)) / (len(motion) - 1)
    way = np.interp(time, [0.0, 0.4, 0.5, 0.7, 1.0], [0.6, 0.2, 0.0, 0.0, 0.0])[:, None] * [0.0, 0.5, 1.0]
    off = np.interp(time, [0.45, 0.55, 0.65, 0.8], [0.0, 1.0, 1.0, 0.0])[:, None] * np.array(away)
    return replace(motion, root=GOAL[:3] + way + off)


@pytest.mark.parametrize("away", [(0.0, 0.0, -0.15), (0.0, -0.08, 0.0), (0.02, -0.05, -0.1)])
def test_the_pelvis_stays_on_the_seat(away):
    before = sitting(away)
    after = kept_on(before, GOAL)
    off = after.root - GOAL[:3]
    assert off[:, 2].min() > -GIVE - 1e-3 and off[:, 1].min() > -GIVE - 1e-3
    np.testing.assert_allclose(after.root[:30], before.root[:30], atol=1e-6)
    np.testing.assert_allclose(after.root[-10:], before.root[-10:], atol=1e-3)
    np.testing.assert_allclose(after.root[:, 0], before.root[:, 0], atol=1e-6)
    assert np.abs(np.diff(after.root, axis=0)).max() <= np.abs(np.diff(before.root, axis=0)).max() + 0.005


@pytest.mark.parametrize("away", [(0.0, 0.0, 0.0), (0.1, 0.02, 0.1), (0.0, -GIVE / 2, -GIVE / 2)])
def test_a_pelvis_with_room_stays_as_it_is(away):
    motion = sitting(away)
    assert kept_on(motion, GOAL) is motion
