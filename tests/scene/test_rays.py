"""The first surface on a ray, against every triangle for itself."""

from __future__ import annotations

import numpy as np
import pytest
from samp_blender.samp_addon.scene.geometry import SceneGeometry
from samp_blender.samp_addon.scene.rays import Rays, _distances


@pytest.fixture(scope="module")
def soup():
    rng = np.random.default_rng(1)
    middles = rng.uniform(-5, 5, (900, 1, 3))
    triangles = middles + rng.normal(0, 0.4, (900, 3, 3))
    return SceneGeometry.from_objects([(f"Part {k}", triangles[k * 90 : (k + 1) * 90]) for k in range(10)])


@pytest.mark.parametrize("seed", range(20))
def test_the_first_surface(soup, seed):
    rng = np.random.default_rng(seed)
    origin, direction = rng.uniform(-8, 8, 3), rng.normal(size=3) * rng.uniform(0.1, 10)
    at = _distances(soup.triangles, origin, direction)
    hit = Rays(soup).first(origin, direction)
    if not np.isfinite(at).any():
        assert hit is None
        return
    np.testing.assert_allclose(hit.point, origin + at.min() * direction, atol=1e-9)
    assert hit.name == soup.names[soup.object_ids[at.argmin()]]
    assert hit.normal @ direction < 0 and np.linalg.norm(hit.normal) == pytest.approx(1)


def test_triangles_in_a_box(soup):
    low, high = np.array([-1.0, -1.0, -1.0]), np.array([1.0, 2.0, 1.0])
    wanted = ((soup.triangles.min(1) <= high) & (soup.triangles.max(1) >= low)).all(1)
    np.testing.assert_array_equal(np.sort(Rays(soup).in_box(low, high)), np.flatnonzero(wanted))


def test_nothing_in_an_empty_scene():
    assert Rays(SceneGeometry()).first(np.zeros(3), np.ones(3)) is None
