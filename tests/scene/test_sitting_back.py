"""Goals to sit are moved back to the rest, as far as the shins allow."""

import numpy as np
import pytest
from samp_blender.samp_addon.motion import Goal
from samp_blender.samp_addon.scene.seats import back, seats
from shapes import box


def sofa(depth, rest=True):
    """Return a sofa whose seat reaches from z = 0, where its back is, to ``depth``."""
    parts = [box((-0.9, 0.0, 0.0), (0.9, 0.43, depth))]
    parts += [box((-0.9, 0.0, -0.15), (0.9, 0.9, 0.0))] if rest else []
    return np.concatenate(parts)


@pytest.mark.parametrize(
    "depth, rest, start, expected",
    [
        (0.45, True, 0.25, 0.14),  # the rest stops the body
        (0.65, True, 0.45, 0.29),  # the shins do
        (0.45, True, 0.14, 0.14),  # it is there already
        (0.45, False, 0.25, 0.25),
    ],
)
def test_how_far_back(depth, rest, start, expected):
    grid = seats.support_map(sofa(depth, rest), 0.0)
    goal = Goal(np.array([0.1, 0.61, start]), np.array([0.0, 0.0, 1.0]), "sit")
    moved = back.slid_back(grid, goal)
    assert moved.position[2] == pytest.approx(expected, abs=0.035)
    assert moved.position[[0, 1]] == pytest.approx([0.1, 0.61], abs=0.02)
    assert moved.direction == pytest.approx(goal.direction, abs=1e-6)


def test_a_share_of_the_way():
    grid = seats.support_map(sofa(0.65), 0.0)
    goal = Goal(np.array([0.0, 0.61, 0.45]), np.array([0.0, 0.0, 1.0]), "sit")
    whole, half = (back.slid_back(grid, goal, share).position[2] for share in (1.0, 0.5))
    assert half == pytest.approx((whole + 0.45) / 2, abs=0.01)
