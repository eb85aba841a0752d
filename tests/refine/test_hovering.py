"""Hovering bodies are lowered, jumping ones are not; feet roll without twisting on the floor."""

from dataclasses import replace

import numpy as np
import pytest
from bodies import FLOOR, standing
from samp_blender.samp_addon import rotation
from samp_blender.samp_addon.body import human
from samp_blender.samp_addon.refine import hovering
from samp_blender.samp_addon.refine.feet import plan, stances
from samp_blender.samp_addon.refine.field import Field


@pytest.fixture(scope="module")
def floor():
    return Field(FLOOR, np.zeros(len(FLOOR)), 0.0, np.array([[0.0, 1.0, 0.0]]))


def raised(height):
    """A body that stands still, raised by height(seconds (T,)) metres."""
    motion = standing(2.0)
    return replace(motion, root=motion.root + np.outer(height(np.arange(len(motion)) / 30), [0.0, 1.0, 0.0]))


def jump(t, speed):
    """Return the height (T,) of a ballistic jump that starts at 0.6 s with this speed, m/s."""
    return np.maximum(speed * (t - 0.6) - 0.5 * 9.81 * (t - 0.6) ** 2, 0.0) * (t > 0.6)


HEIGHTS = {
    "stands": (lambda t: 0 * t, 0.0),
    "hovers for a second": (lambda t: 0.1 * ((t > 0.5) & (t < 1.5)), 0.1),
    "higher than the distance band": (lambda t: 0.25 * (t > 1.0), 0.25),
    "is meant to be up there": (lambda t: 0.5 * (t > 1.0), 0.0),
    "jumps": (lambda t: jump(t, 3.0), 0.0),
    "hops": (lambda t: jump(t, 1.7), 0.0),
    "stands in the floor": (lambda t: -0.05 * (t > 1.0), 0.0),
}


@pytest.mark.parametrize("name", HEIGHTS)
def test_hover_height(name, floor):
    height, wanted = HEIGHTS[name]
    found = hovering.hover_height(raised(height), floor, human.load())
    assert found.max() == pytest.approx(wanted, abs=0.012)


def test_hovering_bodies_are_lowered_until_they_touch(floor):
    motion = raised(lambda t: 0.12 * np.sin(np.pi * np.clip(t - 0.5, 0, 1)) ** 2)
    settled = hovering.settle(motion, floor, human.load())
    lowest = human.skin(human.load(), settled, human.load().collision)[..., 1].min(1)
    assert np.abs(lowest).max() < 0.02
    np.testing.assert_allclose(settled.root[:8], motion.root[:8], atol=2e-3)


def test_a_rolling_foot_pitches_at_first_and_turns_later():
    sole = np.array([0.0, -0.08, -0.05]), np.array([0.0, -0.08, 0.12])
    still = np.array([1.0, 0.0, 0.0, 0.0])
    vectors = np.array([[0.05, 0.2, 0.1], [0.8, 0.2, 0.1]])
    pitched = rotation.to_axis_angle(plan.pitch_first(rotation.from_axis_angle(vectors), still, sole))
    np.testing.assert_allclose(pitched[0], [0.05, 0.0, 0.0], atol=0.02)
    np.testing.assert_allclose(pitched[1], vectors[1], atol=1e-6)


def test_steps_are_bridged_and_flights_are_not():
    stance = lambda first, last: stances.Stance(first, last)
    feet = [[stance(0, 10)], [stance(16, 30)]]
    supported = np.ones(30, bool)
    right, left = stances.bridge(feet, supported, 30.0)
    assert right[0].last == left[0].first
    supported[10:16] = False
    assert stances.bridge(feet, supported, 30.0) == feet
