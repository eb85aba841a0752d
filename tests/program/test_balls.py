"""The balls of a body lie inside its skin and cover it."""

from __future__ import annotations

import numpy as np
import pytest
from samp_blender.samp_addon import rotation
from samp_blender.samp_addon.body import balls, human
from samp_blender.samp_addon.motion import Motion
from scipy.spatial import cKDTree


@pytest.mark.parametrize("shapes", [{}, {"tall": 1.0}, {"heavy": 1.0}])
def test_they_fill_the_body(shapes):
    body = human.load().shaped(shapes)
    made = balls.of_body(body)
    assert 40 < len(made.radii) < 200
    inside, _ = cKDTree(body.vertices).query(made.centres.vertices)
    assert (inside > made.radii - 2e-3).all()  # no ball reaches out of the skin
    away = np.linalg.norm(body.vertices[body.collision][:, None] - made.centres.vertices, axis=-1)
    out = (away - made.radii).min(1)
    assert np.percentile(out, 90) < 0.03 and out.max() < 0.07


def test_they_follow_the_skin():
    body = human.load()
    made = balls.of_body(body)
    rng = np.random.default_rng(0)
    rotations = rotation.from_axis_angle(rng.normal(size=(3, 22, 3)) * 0.25)
    motion = Motion(rng.normal(size=(3, 3)), rotations)
    centres, skin = made.at(motion), human.skin(body, motion)
    for frame in range(3):
        inside, _ = cKDTree(skin[frame]).query(centres[frame])
        assert np.median(inside - made.radii) == pytest.approx(0, abs=0.01)
        assert (inside > 0.6 * made.radii - 0.01).mean() > 0.95


def test_bodies_of_one_shape_share_them():
    assert balls.of_body(human.load()) is balls.of_body(human.load().shaped({}))
