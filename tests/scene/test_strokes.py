"""Drawn lines as way-points."""

from __future__ import annotations

import numpy as np
import pytest
from samp_blender.samp_addon.scene import strokes

TURN = np.linspace(0, np.pi, 60)
LINES = {
    "straight": (np.linspace((0, 0, 0), (3, 0, 0), 50), 2),
    "corner": (np.concatenate([np.linspace((0, 0, 0), (2, 0, 0), 30), np.linspace((2, 0, 0), (2, 2, 0), 30)]), 3),
    "trembling": (np.linspace((0, 0, 0), (3, 0, 0), 50) + 0.05 * np.sin(np.arange(50))[:, None] * [0, 1, 0], 2),
    "tiny": (np.array([[0, 0, 0], [0.01, 0, 0]]), 2),
    "one point": (np.zeros((1, 3)), 1),
    "nothing": (np.zeros((0, 3)), 0),
    "not a number": (np.array([[0, 0, 0], [np.nan, 0, 0], [2, 0, 0]]), 2),
}  # fmt: skip


@pytest.mark.parametrize("name", LINES)
def test_as_few_as_the_line_needs(name):
    line, count = LINES[name]
    assert len(strokes.waypoints(line)) == count


def test_a_bend_stays_near_the_line():
    line = 2 * np.stack([np.cos(TURN), np.sin(TURN), np.zeros(60)], -1)
    found = strokes.waypoints(line)
    np.testing.assert_array_equal(found[[0, -1]], line[[0, -1]])
    dense = np.concatenate([np.linspace(a, b, 20) for a, b in zip(found[:-1], found[1:], strict=True)])
    gaps = np.linalg.norm(line[:, None] - dense[None], axis=-1).min(1)
    assert gaps.max() < strokes.TOLERANCE + 0.1
    assert np.linalg.norm(np.diff(found, axis=0), axis=-1).min() >= strokes.SPACING - 1e-9


def test_a_long_scribble_is_bounded():
    rng = np.random.default_rng(0)
    line = np.cumsum(rng.normal(0, 0.5, (2000, 3)), 0)
    assert len(strokes.waypoints(line)) <= strokes.MOST
