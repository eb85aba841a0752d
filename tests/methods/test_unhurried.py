"""Bodies move over a mattress no faster than captured ones, through the same places."""

from dataclasses import replace

import numpy as np
import pytest
from samp_blender.samp_addon.methods.samp.finishing.unhurried import MOST, unhurried
from samp_blender.samp_addon.motion import Motion

GOAL = np.array([0.0, 0.5, 0.0, 0.0, 0.0, 1.0, 0, 0, 0, 0, 1.0])


def slides(speed, height=0.55):
    """Return a motion that moves by a metre in its middle, at a height of the pelvis, and rests before and after."""
    count = round(30 / speed)
    along = np.concatenate([np.zeros(30), np.linspace(0, 1, count), np.ones(30)])
    root = np.stack([along, np.full(len(along), height), np.zeros(len(along))], -1)
    quats = np.zeros((len(along), 22, 4))
    quats[..., 0] = 1
    return Motion(root, quats, actions=np.tile(np.eye(5)[4], (len(along), 1)), interaction_start=10)


@pytest.mark.parametrize("speed", [0.8, 1.5])
def test_a_fast_body_takes_longer(speed):
    before = slides(speed)
    after, heights = unhurried(before, np.arange(len(before)) * 1.0, GOAL)
    now = np.linalg.norm(np.gradient(after.root, 1 / 30, axis=0), axis=-1)
    assert now.max() < 1.15 * MOST and len(after) > len(before) + 5
    assert np.allclose(after.root[[0, -1]], before.root[[0, -1]], atol=0.01)
    assert len(heights) == len(after) == len(after.actions)
    assert np.allclose(np.interp(heights, np.arange(len(before)), before.root[:, 0]), after.root[:, 0])


@pytest.mark.parametrize(
    "motion",
    [slides(0.4), slides(1.5, height=0.9), replace(slides(1.5), interaction_start=None)],
    ids=["slow", "on its feet", "no rest"],
)
def test_others_stay_as_they_are(motion):
    assert unhurried(motion, np.zeros(len(motion)), GOAL)[0] is motion
