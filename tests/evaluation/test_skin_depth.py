"""The depth of thin things in a body, against winding numbers and distances of all its triangles."""

import numpy as np
import pytest
from samp_blender.samp_addon.body import human
from samp_blender.samp_addon.evaluation import collision, skin_depth
from samp_blender.samp_addon.evaluation.obstacles import Obstacles, shared
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.scene.distance.surface_samples import FixedSamples, samples_in_box, without_twins
from samp_blender.samp_addon.scene.geometry import closest_points

FLOOR = -human.load().floor
SEAT = 0.35  # metres over the floor: a height at which sheets cross the shins of a standing body


def standing(frames=1):
    rotations = np.zeros((frames, 22, 4))
    rotations[..., 0] = 1
    return Motion(np.tile([0.0, FLOOR, 0.0], (frames, 1)), rotations)


def rectangle(low, high):
    """Return two triangles of a horizontal rectangle at the height of low."""
    (x0, y, z0), (x1, _, z1) = low, high
    a, b, c, d = [(x0, y, z0), (x0, y, z1), (x1, y, z1), (x1, y, z0)]
    return np.array([[a, b, c], [a, c, d]], float)


THIN = {
    "sheet": rectangle((-0.5, SEAT, -0.5), (0.5, SEAT, 0.5)),
    "slats": np.concatenate([rectangle((-0.5, SEAT, z), (0.5, SEAT, z + 0.02)) for z in (-0.1, -0.03, 0.04)]),
    "wire": np.concatenate([rectangle((-0.5, SEAT + d, 0.0), (0.5, SEAT + d, 0.004)) for d in (0, 0.004)]),
    "two-sided sheet": np.concatenate(
        [part := rectangle((-0.5, SEAT, -0.5), (0.5, SEAT, 0.5)), part[:, ::-1]]
    ),
}


def brute_force(points):
    """Return the depths (N,) of points in the standing body: winding number and distance over all triangles."""
    body, skin = human.load(), human.skin(human.load(), standing())[0].astype(float)
    quads = body.faces
    triangles = skin[np.concatenate([quads[:, :3], quads[quads[:, 2] != quads[:, 3]][:, [0, 2, 3]]])]
    depths = np.zeros(len(points))
    for k, point in enumerate(points):
        a, b, c = (triangles[:, i] - point for i in range(3))
        la, lb, lc = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
        solid = np.einsum("ni,ni->n", a, np.cross(b, c))
        below = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
        if np.arctan2(solid, below).sum() > np.pi:
            near = closest_points(np.tile(point, (len(triangles), 1)), triangles)
            depths[k] = np.linalg.norm(near - point, axis=-1).min()
    return depths


@pytest.mark.parametrize("name", THIN)
def test_thin_things_in_the_shins_are_measured_to_the_nearest_skin(name):
    found = collision.surface_depth(standing(), Obstacles(THIN[name]), floor=0.0)[0]
    low, high = np.array([-0.4, 0.1, -0.25]), np.array([0.4, 0.6, 0.25])
    points = samples_in_box(THIN[name], low, high, 0.008)[0]
    true = brute_force(points[:: max(1, len(points) // 500)]).max()
    assert true > 0.005
    assert found == pytest.approx(true, abs=0.005)


def test_the_reported_depth_has_both_parts():
    numbers = collision.measures(standing(2), Obstacles(THIN["sheet"]), 0.0)
    assert numbers["penetration_2cm_percent"] == 100
    assert numbers["penetration_max_cm"] > 3
    free = collision.measures(standing(2), Obstacles(THIN["sheet"] + [0.0, 2.0, 0.0]), 0.0)
    assert free["penetration_max_cm"] == pytest.approx(0, abs=0.1)


def test_samples_of_a_huge_ground_are_those_in_the_box():
    ground = rectangle((-1000.0, 0.0, -1000.0), (1000.0, 0.0, 1000.0))
    samples, owners = samples_in_box(ground, np.array([3.0, -1, 5.0]), np.array([4.0, 1, 6.0]))
    assert len(samples) == pytest.approx(1 / 0.015**2, rel=0.3)
    assert set(owners) <= {0, 1}
    assert samples.min(0)[[0, 2]] == pytest.approx([3, 5], abs=0.05)
    assert samples.max(0)[[0, 2]] == pytest.approx([4, 6], abs=0.05)


@pytest.mark.parametrize("name", ["sheet", "wire", "huge", "mesh"])
def test_fixed_samples_do_not_depend_on_the_box(name):
    """The samples of a box are those of any box around it, as dense as asked for, and all over it."""
    rng = np.random.default_rng(0)
    surfaces = THIN | {
        "huge": rectangle((-1000.0, 0.0, -1000.0), (1000.0, 0.0, 1000.0)),
        "mesh": np.concatenate(
            [rectangle((x, 0.1, 0), (x + 0.01, 0.1, 0.5)) for x in np.arange(0, 0.5, 0.01)]
        ),
    }
    fixed = FixedSamples(surfaces[name])
    low, high = np.array([0.0, -1.0, -0.1]), np.array([0.4, 1.0, 0.4])
    (inner, _), (outer, owners) = fixed.within(low, high), fixed.within(low - 1.3, high + 0.7)
    kept = outer[((outer >= low) & (outer <= high)).all(1)]
    rows = lambda points: points[np.lexsort(points.T)]
    np.testing.assert_array_equal(rows(inner), rows(kept))
    assert len(inner) and len(owners) == len(outer)
    if name in ("huge", "mesh"):
        places = rng.uniform(low + [0, 0, 0.1], high, (200, 3))[:, [0, 2]]
        gaps = np.linalg.norm(places[:, None] - inner[:, [0, 2]], axis=-1).min(1)
        assert gaps.max() < 0.03
        area = 0.4 * (0.5 if name == "huge" else 0.4)
        assert len(inner) == pytest.approx(area / 0.015**2, rel=0.1)


def test_equal_triangles_share_obstacles_and_others_do_not():
    scene = THIN["slats"]
    assert shared(scene) is shared(scene.copy())
    assert shared(scene) is not shared(scene + 1.0)


def test_a_take_measures_the_same_whatever_was_measured_before():
    motion, scene = standing(2), THIN["slats"]
    used = Obstacles(scene)
    for away in ([2.0, 0.0, 0.0], [-3.0, 0.3, 1.0], [0.2, 0.0, 0.1]):
        collision.measures(Motion(motion.root + away, motion.rotations), used, 0.0)
    assert collision.measures(motion, used, 0.0) == collision.measures(motion, Obstacles(scene), 0.0)


@pytest.mark.parametrize("floor", [0.003, 0.008, 0.02, None])
def test_floors_a_few_millimetres_apart_measure_what_each_does_alone(floor):
    carpet = rectangle((-0.5, 0.006, -0.5), (0.5, 0.006, 0.5))
    motion, scene = standing(2), np.concatenate([THIN["sheet"], carpet])
    used = Obstacles(scene)
    for other in (0.0, 0.004, 0.015):
        collision.measures(motion, used, other)
    assert collision.measures(motion, used, floor) == collision.measures(motion, Obstacles(scene), floor)


def test_points_over_all_planes_around_them_are_outside(monkeypatch):
    body = human.load()
    surface = skin_depth.surface_of(body)
    skin, joints = human.skin(body, standing(), surface.vertices)[0], body.joints + [0.0, FLOOR, 0.0]
    rng = np.random.default_rng(0)
    near = skin[rng.integers(len(skin), size=3000)]
    points = near + rng.normal(scale=0.01, size=near.shape)
    found, deepest = surface.inside(skin, points, joints), surface.deepest(skin, points, joints)
    everything = lambda self, skin, points, found: (np.arange(len(found.rows)), found.near(found.rows))
    monkeypatch.setattr(skin_depth.SkinSurface, "_unclear", everything)
    without = surface.inside(skin, points, joints)
    assert 500 < len(found.index) < 2500
    for name in ("index", "depth", "out", "vertex"):
        np.testing.assert_array_equal(getattr(found, name), getattr(without, name))
    assert deepest == surface.deepest(skin, points, joints)


def test_twins_are_dropped_and_neighbours_kept():
    part = rectangle((0, 0, 0), (1, 0, 1))
    single, keep = without_twins(np.concatenate([part, part[:, ::-1], part + [1.0, 0, 0]]))
    assert keep.tolist() == [True, True, False, False, True, True]
    np.testing.assert_array_equal(single, np.concatenate([part, part + [1.0, 0, 0]]))
