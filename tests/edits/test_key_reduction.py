"""Fewer keys within a bound: the bound holds in every frame, and smooth motion needs few keys."""

import numpy as np
import pytest
from samp_blender.samp_addon import rotation
from samp_blender.samp_addon.edits import key_reduction as reduction

TIME = np.arange(300) / 30


def turning(noise):
    """Return quaternions (300, 4) of a body that turns, nods and trembles."""
    angles = np.stack([0.4 * np.sin(2 * TIME), 0.8 * TIME, 0.1 * np.cos(5 * TIME)], -1)
    angles += noise * np.random.default_rng(0).normal(size=angles.shape)
    return rotation.continuous(rotation.from_axis_angle(angles))


@pytest.mark.parametrize("degrees", [0.02, 0.1, 1.0])
@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_rotations_stay_within_the_bound(degrees, noise):
    values, bound = turning(noise), np.radians(degrees)
    keys = reduction.reduced(values, reduction.angle_error, bound)
    made = reduction.interpolated(values, keys)
    assert reduction.angle_error(made, values).max() <= bound + 1e-12
    assert keys.frames[0] == 0 and keys.frames[-1] == 299 and (np.diff(keys.frames) > 0).all()
    assert keys.slopes.shape == (len(keys.frames) - 1, 2, 4)
    if not noise:
        assert len(keys.frames) < 75, "smooth motion needs a quarter of the keys at most"


def test_angles_between_quaternions_are_exact_for_small_ones():
    turned = rotation.from_axis_angle(np.array([[1e-4, 0, 0], [0, 2.0, 0]]))
    still = np.tile([1.0, 0, 0, 0], (2, 1))
    assert reduction.angle_error(3 * turned, still) == pytest.approx([1e-4, 2.0], rel=1e-6)


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5])
def test_short_channels(count):
    values = np.random.default_rng(count).normal(size=(count, 3))
    keys = reduction.reduced(values, reduction.distance_error, 1e-9)
    assert reduction.interpolated(values, keys) == pytest.approx(values, abs=1e-9)


def test_a_channel_that_does_not_move_has_one_key():
    values = np.full((50, 3), 2.0) + 1e-5
    keys = reduction.reduced(values, reduction.distance_error, 1e-3)
    assert keys.frames.tolist() == [0] and len(keys.slopes) == 0
    assert reduction.interpolated(values, keys).shape == (50, 3)


def test_a_cubic_needs_two_keys():
    values = np.stack([TIME**3 - 4 * TIME**2, 2 * TIME], -1)[:200]
    keys = reduction.reduced(values, reduction.distance_error, 1e-6)
    assert keys.frames.tolist() == [0, 199]
    assert keys.slopes[0, 1] * 30 == pytest.approx([3 * TIME[199] ** 2 - 8 * TIME[199], 2.0], rel=1e-6)
