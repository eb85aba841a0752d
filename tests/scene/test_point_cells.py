"""Boxes of points by cells, against looking at all points."""

import numpy as np
import pytest
from samp_blender.samp_addon.scene.distance.point_cells import PointCells

POINTS = np.random.default_rng(0).uniform(-3, 2, (2000, 3))


@pytest.mark.parametrize(
    ("low", "high"),
    [
        ((-1, -1, -1), (0.5, 0.3, 0)),
        ((-9, -9, -9), (9, 9, 9)),
        ((1.9, 1.9, 1.9), (8, 8, 8)),
        ((3, 3, 3), (4, 4, 4)),
    ],
)
def test_all_points_of_a_box_and_few_others_are_found(low, high):
    low, high = np.array(low, float), np.array(high, float)
    found = PointCells(POINTS, 0.2).within(low, high)
    assert len(set(found)) == len(found)
    inside = np.flatnonzero((np.clip(POINTS, low, high) == POINTS).all(1))
    assert set(inside) <= set(found)
    assert (np.abs(np.clip(POINTS, low, high) - POINTS)[found] <= 0.2).all()


def test_no_points_have_no_boxes():
    assert len(PointCells(np.zeros((0, 3))).within(np.zeros(3), np.ones(3))) == 0
