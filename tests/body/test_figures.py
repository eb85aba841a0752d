"""Plain poses: where the soles, the head and the back are."""

from __future__ import annotations

import numpy as np
import pytest
from samp_blender.samp_addon.body import figures, human


def skin(action, over_floor=0.6):
    return human.skin(human.load(), figures.figure(action, over_floor))[0]


@pytest.mark.parametrize("over_floor", [0.45, 0.55, 0.65, 0.75])
def test_the_feet_of_a_seated_body_are_on_the_floor(over_floor):
    points = skin("sit", over_floor)
    assert points[:, 1].min() == pytest.approx(-over_floor, abs=0.08)
    assert points[points[:, 1].argmin(), 2] > 0.2  # before the seat


def test_a_body_lies_on_its_back_with_its_feet_ahead():
    points = skin("lie")
    assert np.ptp(points[:, 1]) < 0.45 and points[:, 2].max() > 0.8
    assert points[:, 2].min() < -0.6


def test_a_body_stands():
    points = skin("walk")
    assert points[:, 1].min() == pytest.approx(human.load().floor, abs=0.01)
    assert np.ptp(points[:, 0]) < 0.8
