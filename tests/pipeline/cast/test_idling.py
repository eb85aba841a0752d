"""The end of a take that is held longer, until the others of its cast are done."""

from __future__ import annotations

import numpy as np
import pytest
from samp_blender.samp_addon.methods.take import Take
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.pipeline.cast import idling

FPS = 30


def ending(hold: float, sway: float) -> Take:
    """A take that glides at 1 m/s for two seconds, then sways at the pelvis for some seconds."""
    walk, rest = 2 * FPS, round(hold * FPS)
    x = np.concatenate([np.linspace(-2, 0, walk), sway * np.sin(np.arange(rest) / 7)])
    root = np.stack([x, np.full(len(x), 0.93), np.zeros(len(x))], axis=-1)
    return Take(0, Motion(root, np.tile([1.0, 0, 0, 0], (len(x), 22, 1))))


@pytest.mark.parametrize("hold", [0.0, 0.4, 1.0, 3.0])
def test_a_walk_that_has_just_ended_is_not_played_backwards(hold):
    take = ending(hold, 0.01)
    made = idling.lengthened(take, len(take.motion) + 200).motion
    assert len(made) == len(take.motion) + 200
    assert (made.root[: len(take.motion)] == take.motion.root).all()
    assert np.abs(made.root[len(take.motion) :] - take.motion.root[-1]).max() <= idling.STILL
    assert np.abs(np.diff(made.root[len(take.motion) :], axis=0)).max() < 0.04


def test_a_body_at_rest_goes_on_to_sway():
    take = ending(3.0, 0.01)
    added = idling.lengthened(take, len(take.motion) + 200).motion.root[len(take.motion) :]
    assert len(np.unique(added[:, 0].round(6))) > FPS  # not a frozen pose


def test_a_take_that_is_long_enough_stays():
    take = ending(1.0, 0.0)
    assert idling.lengthened(take, 10) is take
