"""Metrics of perfect takes, and of takes with known faults."""

from dataclasses import replace

import numpy as np
import pytest
import rooms
from samp_blender.samp_addon import rotation
from samp_blender.samp_addon.body import human
from samp_blender.samp_addon.evaluation import collision, diversity, feet, metrics, obstacles
from samp_blender.samp_addon.evaluation.obstacles import Obstacles
from samp_blender.samp_addon.motion import Goal, Motion
from samp_blender.samp_addon.scene.distance import solids

FLOOR = -human.load().floor  # the pelvis' height of the standing default human


def box(low, high, flip=False, without=()):
    """Triangles of a box with outward normals; `without` names faces left open, such as 'bottom'."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    quads = {
        "left": [(x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)],
        "right": [(x1, y0, z0), (x1, y1, z0), (x1, y1, z1), (x1, y0, z1)],
        "bottom": [(x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)],
        "top": [(x0, y1, z0), (x0, y1, z1), (x1, y1, z1), (x1, y1, z0)],
        "back": [(x0, y0, z0), (x0, y1, z0), (x1, y1, z0), (x1, y0, z0)],
        "front": [(x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)],
    }
    triangles = [[q[0], *pair] for n, q in quads.items() if n not in without for pair in (q[1:3], q[2:4])]
    triangles = np.array(triangles, float)
    return triangles[:, ::-1] if flip else triangles


def standing(seconds=3.0, at=(0.0, FLOOR, 0.0), yaw=0.0, speed=0.0, fps=30.0):
    """Return the rest pose, moving along +Z at a constant speed, m/s."""
    frames = int(seconds * fps) + 1
    root = np.tile(np.asarray(at, float), (frames, 1))
    root[:, 2] += speed * np.arange(frames) / fps
    rotations = np.zeros((frames, 22, 4))
    rotations[..., 0] = 1
    rotations[:, 0] = rotation.about_y(yaw)
    return Motion(root, rotations, fps)


GOAL = Goal(np.array([0.0, FLOOR, 0.0]), np.array([0.0, 0.0, 1.0]), "idle")


def test_a_perfect_take_scores_perfectly():
    numbers = metrics.measure(standing(), GOAL, Obstacles(box((2, 0, 2), (3, 1, 3))))
    assert numbers["success"] is True
    assert numbers["execution_time_s"] == 0
    assert numbers["non_collision"] == 1
    zero = ["position_error_cm", "rotation_error_deg", "jerk_m_s3", "foot_slide_cm_s", "stance_slide_cm_s"]
    zero += ["penetration_2cm_percent", "penetration_5cm_percent", "penetration_max_cm"]
    for name in zero:
        assert numbers[name] == pytest.approx(0, abs=1e-3), name
    assert numbers["stance_share"] == 1


@pytest.mark.parametrize("offset", [(0.1, 0, 0), (0, -0.1, 0), (0, 0, 0.1)])
def test_position_error_of_ten_centimetres(offset):
    moved = standing(at=np.add(GOAL.position, offset))
    assert metrics.position_error(moved, GOAL) == pytest.approx(10, abs=1e-6)


@pytest.mark.parametrize("degrees", [90, -90, 180, 20])
def test_rotation_error_of_a_turn(degrees):
    assert metrics.rotation_error(standing(yaw=np.radians(degrees)), GOAL) == pytest.approx(abs(degrees))


@pytest.mark.parametrize(
    ("motion", "reached"),
    [
        (standing(), True),
        (standing(seconds=0.5), False),  # too short to hold the goal for a second
        (standing(at=(0.25, FLOOR, 0)), False),
        (standing(at=(0, FLOOR, -3.0), speed=1.0), False),  # reaches the goal in its last frame only
    ],
)
def test_success_needs_the_whole_last_second(motion, reached):
    assert metrics.success(motion, GOAL) is reached


def test_execution_time_counts_to_the_stop():
    walk, stop = standing(2, (0, FLOOR, -2), speed=1.0), standing(2)
    take = replace(
        walk, root=np.concatenate([walk.root, stop.root]), rotations=np.tile(walk.rotations, (2, 1, 1))
    )
    assert metrics.execution_time(take, GOAL) == pytest.approx(2.03, abs=0.05)
    assert metrics.execution_time(walk, GOAL) is None  # passes by, never slow


def test_jerk_of_a_known_wave():
    motion = standing(6)
    t = np.arange(len(motion)) / 30
    root = motion.root.copy()
    root[:, 0] = 0.1 * np.sin(2 * np.pi * t)
    assert metrics.jerk(replace(motion, root=root)) == pytest.approx(0.1 * (2 * np.pi) ** 3, rel=0.02)


@pytest.mark.parametrize(
    ("height", "speed", "slide"),
    [
        (0.0, 0.5, 50.0),
        (0.0125, 0.5, 50 * (2 - 2**0.5)),
        (0.03, 0.5, 0.0),
        (0.0, 0.0, 0.0),
        (-0.02, 0.5, 50.0),
    ],
)
def test_foot_slide_formula(height, speed, slide):
    gliding = standing(at=(0, FLOOR + height, 0), speed=speed)
    assert feet.measures(gliding)["foot_slide_cm_s"] == pytest.approx(slide, abs=0.01)


def test_stance_slide_counts_slow_drift_only():
    assert feet.measures(standing(speed=0.1))["stance_slide_cm_s"] == pytest.approx(10, abs=1e-3)
    fast = feet.measures(standing(speed=0.5))
    assert fast["stance_slide_cm_s"] is None
    assert fast["stance_share"] == 0


def test_a_stance_lasts_five_frames():
    still = np.zeros((12, 2))
    speed = np.full((12, 2), 50.0)
    speed[2:6, 0], speed[2:7, 1] = 1, 1
    assert feet.stances(speed, still, 30).sum(0).tolist() == [0, 5]


CHEST = (-0.5, 1.2, -0.5)
SOLIDS = {
    "closed": box(CHEST, (0.5, 3, 0.5)),
    "bottom open": box(CHEST, (0.5, 3, 0.5), without=["bottom"]),
    "in a room of one inward sheet": np.concatenate(
        [box(CHEST, (0.5, 3, 0.5)), box((-4, 0, -4), (4, 4, 4), flip=True)]
    ),
    "in a room of one outward box": np.concatenate([box(CHEST, (0.5, 3, 0.5)), box((-4, 0, -4), (4, 4, 4))]),
    "with one wall": np.concatenate([box(CHEST, (0.5, 3, 0.5)), box((-4, 0, -4), (4, 4, 4))[:2]]),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_penetration_of_a_box(name):
    """The head moves into a suspended box; its depth is its height over the box's bottom."""
    motion = standing(1.0, (0, FLOOR, -1.5), speed=1.5)
    numbers = collision.measures(motion, Obstacles(SOLIDS[name]))
    top = FLOOR + float(human.load().vertices[:, 1].max())
    inside = 100 * np.mean(motion.root[:, 2] > -0.5)
    if name != "bottom open":  # without its bottom the nearest surface of that box is a side
        assert numbers["penetration_max_cm"] == pytest.approx(100 * (top - 1.2), abs=2.5)
    assert numbers["penetration_5cm_percent"] == pytest.approx(inside, abs=20)
    assert numbers["penetration_5cm_percent"] > 15
    assert numbers["non_collision"] < 0.97


@pytest.mark.parametrize(("depth", "percent"), [(-0.05, (0, 0)), (0.035, (100, 0)), (0.08, (100, 100))])
def test_depth_limits(depth, percent):
    """A floor slab reaches up the feet by `depth`."""
    numbers = collision.measures(standing(0.2), Obstacles(box((-2, -1, -2), (2, depth, 2))))
    assert (numbers["penetration_2cm_percent"], numbers["penetration_5cm_percent"]) == percent


def test_inside_and_outside_close_to_a_surface():
    """Vertices close to a slab's top, inside and outside, at any position relative to the grid."""
    slab = box((-0.5, -0.2, -0.5), (0.5, 0.1, 0.5))
    rng = np.random.default_rng(1)
    places = rng.uniform(-0.45, 0.45, (400, 3))
    depth = rng.uniform(-0.018, 0.04, 400)
    depth[np.abs(depth) < 0.001] = 0.001
    places[:, 1] = 0.1 - depth
    free = np.array([[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0]])
    found, touching = Obstacles(slab).depth(np.stack([np.tile(free, (200, 1)), places]))
    np.testing.assert_allclose(found[1], np.maximum(depth, 0), atol=1e-4)
    np.testing.assert_array_equal(touching[1], depth >= -obstacles.CONTACT_DISTANCE)
    assert not found[0].any()


def test_shared_obstacles_give_the_same_results():
    """The loaded region grows with each take."""
    scene = np.concatenate([box((-1, 0, z), (1, 2, z + 0.4)) for z in (5, 12, -9)])
    walks = [standing(4, (0, FLOOR, z), speed=1.5) for z in (0, 7, -14, 0)]
    shared = Obstacles(scene)
    for walk in walks:
        for one, other in zip(
            collision.body_depth(walk, shared, 0.0),
            collision.body_depth(walk, Obstacles(scene), 0.0),
            strict=True,
        ):
            np.testing.assert_allclose(one, other, atol=1e-9)
        assert one.any()


def test_a_take_that_jumps_far_away():
    motion = standing(1.0, (0, FLOOR, -1.5), speed=1.5)
    root = motion.root.copy()
    root[10:20] += [40_000.0, 3_000.0, -70_000.0]
    leaping = replace(motion, root=root)
    depth, touching = collision.body_depth(leaping, Obstacles(SOLIDS["closed"]), floor=0.0)
    plain, _ = collision.body_depth(motion, Obstacles(SOLIDS["closed"]), floor=0.0)
    stays = np.r_[0:10, 20 : len(root)]
    np.testing.assert_allclose(depth[stays], plain[stays], atol=1e-9)
    assert depth.max() > 0 and not depth[10:20].any() and not touching[10:20].any()


def test_deep_inside_a_large_solid():
    """The body is inside although no surface is near its cells."""
    motion = standing(1.0, (0, FLOOR, -4), speed=6.0)
    depth, _ = collision.body_depth(motion, Obstacles(box((-3, -3, -1), (3, 3, 5))))
    assert depth[-1].min() > 1.0


def test_under_a_table_is_outside():
    table = box((-1, 2.0, -1), (1, 2.1, 1))
    numbers = collision.measures(standing(0.2), Obstacles(table))
    assert numbers["penetration_max_cm"] == 0
    assert numbers["contact"] == 0


def test_contact_within_a_centimetre():
    reach = float(human.skin(human.load(), standing(0), human.load().collision)[..., 0].max())
    touch = lambda away: collision.measures(standing(0.1), Obstacles(box((away, 0, -1), (3, 2, 1))))
    assert touch(reach + 0.005)["contact"] == 1
    assert touch(reach + 0.02)["contact"] == 0


def test_depth_below_the_floor():
    sunk = collision.measures(standing(0.1, (0, FLOOR - 0.03, 0)), Obstacles(np.zeros((0, 3, 3))), floor=0.0)
    assert sunk["penetration_max_cm"] == pytest.approx(3, abs=0.2)


@pytest.mark.parametrize("lift", [0.0, 0.005, 0.012, 0.022, -0.005])
def test_a_thick_floor_is_not_penetrated_by_standing_on_it(lift):
    """The soles are within one cell of a slab 10 cm thick with a carpet 8 mm high."""
    slab = np.concatenate([box((-3, -0.1, -3), (3, 0, 3)), box((-1, 0, -1), (1, 0.008, 1))])
    depth, touching = collision.body_depth(
        standing(0.5, (0.003, FLOOR + lift, 0.007)), Obstacles(slab), floor=0.0
    )
    assert depth.max() == pytest.approx(max(-lift, 0), abs=1e-3)
    assert touching.any() == (lift < 0.018)


def test_a_wall_on_a_long_walk():
    """Frames are processed in chunks; exactly those at the wall have depth."""
    walk = standing(4, (0, FLOOR, 0), speed=1.5)
    depth, touching = collision.body_depth(walk, Obstacles(box((-1, 0, 5), (1, 2, 5.4))))
    assert depth.shape == touching.shape == (121, 2048)
    at_wall = np.flatnonzero(depth.max(1) > 0.05)
    place = walk.root[at_wall, 2]
    assert 4.6 < place.min() < 5.0
    assert 5.4 < place.max() < 5.8
    assert len(at_wall) == at_wall[-1] - at_wall[0] + 1
    assert depth.max() == pytest.approx(0.2, abs=0.02)


def test_exact_distance():
    rng = np.random.default_rng(0)
    solid = box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))
    points = rng.uniform(-1, 1, (500, 3))
    outside = np.maximum(np.abs(points) - 0.5, 0)
    inside = 0.5 - np.abs(points).max(-1)
    truth = np.where(inside > 0, inside, np.linalg.norm(outside, axis=-1))
    np.testing.assert_allclose(solids.Surface(solid).nearest(points)[0], truth, atol=1e-3)


def test_diversity():
    assert diversity.diversity([standing(), standing(at=(5, FLOOR, 3), yaw=1.0)]) == pytest.approx(
        0, abs=1e-9
    )
    bent = standing()
    rotations = bent.rotations.copy()
    rotations[:, 16] = rotation.from_axis_angle(np.array([0, 0, 1.0]))
    assert diversity.diversity([standing(), replace(bent, rotations=rotations)]) > 0.1


def test_pairwise_distance_is_the_mean_over_pairs():
    features = np.random.default_rng(0).normal(size=(7, 3))
    pairs = [np.sum((a - b) ** 2) for i, a in enumerate(features) for j, b in enumerate(features) if i != j]
    assert diversity.average_pairwise_distance(features) == pytest.approx(np.mean(pairs))


def test_frechet_distance_of_known_normals():
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(200_000, 2)), rng.normal(size=(200_000, 2)) * [2, 1] + [3, 0]
    assert diversity.frechet_distance(a, b) == pytest.approx(9 + 1, rel=0.02)
    assert diversity.frechet_distance(a, a) == pytest.approx(0, abs=1e-6)


def test_motion_distance_separates_walking_from_standing():
    still, glide = [standing()], [standing(speed=1.0)]
    assert diversity.motion_distance(still, still) == pytest.approx(0, abs=1e-6)
    assert diversity.motion_distance(still, glide) > 1


@pytest.mark.parametrize(
    ("thick", "over", "touches"), [(0.008, 0.012, True), (0.008, 0.03, False), (0.0, 0.012, False)]
)
def test_standing_on_a_carpet_is_contact(thick, over, touches):
    body = human.load()
    motion = Motion(np.array([[0.0, over - body.floor, 0.0]] * 2), np.tile([1.0, 0, 0, 0], (2, 22, 1)))
    carpet = rooms.box(np.array([-1.0, 0.0, -1.0]), np.array([1.0, thick, 1.0]))
    assert collision.body_depth(motion, Obstacles(carpet), 0.0)[1].any(1).all() == touches
