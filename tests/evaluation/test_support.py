"""Squats in the air, flights, gliding seats and hanging feet: takes with each fault, and one without."""

import numpy as np
import pytest
import rooms
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.body import human
from samp_blender.samp_addon.evaluation import guards, support
from samp_blender.samp_addon.evaluation.obstacles import Obstacles
from samp_blender.samp_addon.motion import Goal, Motion

BODY = human.load()


def sitting(seat=0.45, frames=90, lift=0.0, glide=0.0, knees=90.0):
    """Return a body whose thighs lie on a seat of this height; lift, metres over it; glide, m/s; knees, degrees."""
    rotations = np.zeros((frames, 22, 4))
    rotations[..., 0] = 1
    for side in ("left", "right"):
        thigh, knee = skeleton.INDEX[f"{side}_hip"], skeleton.INDEX[f"{side}_knee"]
        rotations[:, thigh] = rotation.from_axis_angle(np.array([-np.pi / 2, 0, 0]))
        rotations[:, knee] = rotation.from_axis_angle(np.array([np.radians(knees), 0, 0]))
    motion = Motion(np.zeros((frames, 3)), rotations)
    lowest = human.skin(BODY, motion.pose_slice(slice(0, 1)), BODY.collision)[0][support.seat_skin(BODY), 1]
    root = np.tile([0.0, seat + lift - lowest.min(), 0.0], (frames, 1))
    root[:, 0] += glide * np.arange(frames) / 30
    return Motion(root, rotations)


def stool(seat):
    """Return a block under hips and thighs, as wide as a bench."""
    return Obstacles(rooms.box(np.array([-3.0, 0.0, -0.3]), np.array([3.0, seat, 0.12])))


def sheet(seat):
    """Return a seat of one sheet."""
    x, z = (-0.4, 0.4), (-0.3, 0.25)
    a, b, c, d = [(x[0], seat, z[0]), (x[0], seat, z[1]), (x[1], seat, z[1]), (x[1], seat, z[0])]
    return Obstacles(np.array([[a, b, c], [a, c, d]]))


def goal_of(motion):
    return Goal(motion.root[-1], np.array([0.0, 0.0, 1.0]), "sit")


@pytest.mark.parametrize(
    ("motion", "scene", "broken"),
    [
        (sitting(0.45), stool(0.45), []),
        (sitting(0.45), sheet(0.45), []),
        (sitting(0.45, lift=0.04), sheet(0.45), []),
        (sitting(0.45, lift=0.12), sheet(0.45), ["air_squat_s"]),
        (sitting(0.45, lift=0.25), stool(0.45), ["air_squat_s", "unsupported_s"]),
        (sitting(0.45, frames=25, lift=0.12), sheet(0.45), []),  # shorter than the limit
        (sitting(0.45, glide=0.8), stool(0.45), ["seated_speed_m_s"]),
        (sitting(0.45, glide=0.3), stool(0.45), []),
        (sitting(0.40, knees=53), stool(0.40), ["hanging_feet_cm"]),
    ],
)
def test_what_nobody_can_do_breaks_a_measure(motion, scene, broken):
    numbers = support.measures(motion, goal_of(motion), scene, 0.0)
    if "hanging_feet_cm" not in broken:
        numbers["hanging_feet_cm"] = None
    assert guards.broken(numbers) == broken, numbers
    assert len(guards.warnings(numbers)) == len(broken)


@pytest.mark.parametrize(
    ("speed", "aloft", "flies"),
    [(0.0, 12, True), (3.0, 12, False), (3.0, 20, True)],
    ids=["standing", "a stride", "longer than any stride"],
)
def test_a_runner_may_fly_for_a_stride(speed, aloft, flies):
    rotations = np.zeros((40, 22, 4))
    rotations[..., 0] = 1
    root = np.tile([0.0, -BODY.floor, 0.0], (40, 1))
    root[10 : 10 + aloft, 1] += 0.2
    root[:, 2] = speed * np.arange(40) / 30
    away = Obstacles(rooms.box(np.array([20.0, 0, 20]), np.array([21.0, 1, 21])))
    found = support.measures(Motion(root, rotations), None, away, 0.0)["unsupported_s"]
    assert found == pytest.approx(aloft / 30 if flies else 0.0)


@pytest.mark.parametrize(("flags", "run"), [([], 0), ([0, 0], 0), ([1, 1, 0, 1], 2), ([0, 1, 0, 1, 1, 1], 3)])
def test_the_longest_run(flags, run):
    assert support.longest(np.array(flags, bool)) == run


def test_warnings_say_what_and_how_much():
    numbers = {"air_squat_s": 2.84, "penetration_max_cm": 7.4, "success": False, "position_error_cm": 56.0}
    said = guards.warnings(numbers)
    assert [any(part in text for text in said) for part in ("2.8 s", "7 cm deep", "56 cm from")] == [True] * 3
    assert guards.warnings({"air_squat_s": 0.9, "penetration_max_cm": 1.0, "success": True}) == []
