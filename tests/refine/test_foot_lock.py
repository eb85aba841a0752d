"""Limb inverse kinematics and the foot lock."""

from dataclasses import replace

import numpy as np
import pytest
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.refine.feet.foot import sole_points, toe_tips
from samp_blender.samp_addon.refine.feet.foot_lock import FOUND, LABELLED, lock_feet
from samp_blender.samp_addon.refine.feet.grounding import grounded, lowest_sole
from samp_blender.samp_addon.refine.feet.stances import from_ground
from samp_blender.samp_addon.refine.inverse_kinematics import LIMBS, solve_limb
from samp_blender.samp_addon.refine.runs import runs

REST = skeleton.default_rest_joints()


def standing(frames):
    """A standing character with slightly bent knees, soles on the floor."""
    quats = np.zeros((frames, 22, 4))
    quats[..., 0] = 1
    for side in ("left", "right"):
        for name, angle in (("hip", -0.2), ("knee", 0.4), ("ankle", -0.2)):
            quats[:, skeleton.INDEX[f"{side}_{name}"]] = rotation.from_axis_angle([angle, 0, 0])
    root = np.zeros((frames, 3))
    positions, globals_ = skeleton.forward_kinematics(root, quats, REST)
    heel, ball = sole_points(positions, globals_, REST, "left")
    root[:, 1] = -min(heel[0, 1], ball[0, 1])
    return root, quats


@pytest.mark.parametrize("limb", sorted(LIMBS))
@pytest.mark.parametrize("offset", [(0.05, 0.03, 0.08), (-0.1, 0.1, 0.0), (0, 0, 0)])
def test_the_limb_ends_on_the_target(limb, offset):
    root, quats = standing(4)
    elbow = skeleton.INDEX[LIMBS[limb][1]]
    if "arm" in limb:
        quats[:, elbow] = rotation.from_axis_angle([0, 0.9 if "right" in limb else -0.9, 0])
    positions, before = skeleton.forward_kinematics(root, quats, REST)
    end = skeleton.INDEX[LIMBS[limb][2]]
    target = positions[:, end] + np.array(offset) * (0.5 if "arm" in limb else 1)
    solved = solve_limb(root, quats, REST, limb, target)
    positions, after = skeleton.forward_kinematics(root, solved, REST)
    assert np.abs(positions[:, end] - target).max() < 1e-6
    assert np.abs(np.abs(np.sum(before[:, end] * after[:, end], -1)) - 1).max() < 1e-9


def test_a_target_out_of_reach_is_approached():
    root, quats = standing(2)
    target = np.array([[0.1, 0.0, 5.0]] * 2)
    solved = solve_limb(root, quats, REST, "left_leg", target)
    positions, _ = skeleton.forward_kinematics(root, solved, REST)
    assert np.isfinite(solved).all()
    hip, ankle = positions[0, 1], positions[0, 7]
    away = (target[0] - hip) / np.linalg.norm(target[0] - hip)
    assert (ankle - hip) @ away > 0.98 * np.linalg.norm(ankle - hip)


def test_runs_close_gaps_and_drop_flicker():
    mask = np.array([0, 1, 1, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1], bool)
    assert runs(mask) == [(1, 6), (13, 16)]


@pytest.mark.parametrize("drift", [0.0, 0.001, 0.003])
def test_stance_feet_stand_still(drift):
    frames = 40
    root, quats = standing(frames)
    root[:, 2] += drift * np.arange(frames)
    contacts = np.tile([0.0, 0, 0, 1, 1], (frames, 1))
    locked = lock_feet(Motion(root, quats, contacts=contacts))
    positions, globals_ = locked.forward_kinematics()
    for side in ("left", "right"):
        ball = positions[:, skeleton.INDEX[f"{side}_foot"]]
        assert np.linalg.norm(np.diff(ball[:, [0, 2]], axis=0), axis=-1).max() * 30 < 0.01
        heel, sole = sole_points(positions, globals_, REST, side)
        assert abs(min(heel[:, 1].min(), sole[:, 1].min())) < 2e-3


@pytest.mark.parametrize("degrees, most", [(20.0, 1.0), (160.0, 160.0)])
@pytest.mark.parametrize("settings", [FOUND, LABELLED], ids=["found", "labelled"])
def test_standing_feet_pivot_before_their_ankles_twist(settings, degrees, most):
    """A foot keeps its facing through a small turn of the body, and turns with the body through a large one."""
    frames = 90
    root, quats = standing(frames)
    turn = np.radians(degrees) * np.clip((np.arange(frames) - 15) / 60, 0, 1)
    quats[:, 0] = rotation.about_y(turn)
    contacts = np.tile([0.0, 0, 0, 1, 1], (frames, 1))
    motion = lock_feet(Motion(root, quats, contacts=contacts), settings=replace(settings, steps=False))
    _, globals_ = motion.forward_kinematics()
    feet = globals_[:, [skeleton.INDEX[f"{side}_ankle"] for side in ("left", "right")]]
    ahead = rotation.rotate(feet, np.broadcast_to([0.0, 0.0, 1.0], (*feet.shape[:2], 3)))
    facing = np.degrees(np.unwrap(np.arctan2(ahead[..., 0], ahead[..., 2]), axis=0))
    against = np.abs(facing - np.degrees(turn)[:, None])
    assert against.max() < 36
    assert np.ptp(facing, axis=0).max() < most


@pytest.mark.parametrize("degrees, count", [(25.0, 1), (80.0, 2)])
def test_a_foot_that_turns_on_its_ball_stands_anew(degrees, count):
    frames = 60
    turn = np.radians(degrees) * np.clip((np.arange(frames) - 10) / 40, 0, 1)
    along = rotation.rotate(rotation.about_y(turn), np.broadcast_to([0.0, 0.0, 0.2], (frames, 3)))
    ball = np.zeros((frames, 3))
    flat = np.zeros(frames)
    found = from_ground([ball - along, ball], [flat, flat], np.ones(frames), 30.0)
    assert len(found) == count


def test_no_foot_sinks_into_the_floor():
    root, quats = standing(30)
    root[:, 1] -= 0.05
    locked = lock_feet(Motion(root, quats, contacts=np.zeros((30, 5))))
    positions, globals_ = locked.forward_kinematics()
    lowest = min(
        sole_points(positions, globals_, REST, side)[k][:, 1].min()
        for side in ("left", "right")
        for k in (0, 1)
    )
    assert lowest > -1e-3


def test_a_walk_without_contacts_is_left_alone():
    root, quats = standing(20)
    root[:, 1] += 0.01
    motion = Motion(root, quats, contacts=np.zeros((20, 5)))
    locked = lock_feet(motion)
    assert np.abs(np.abs(np.sum(locked.rotations * quats, -1)) - 1).max() < 1e-5
    assert np.allclose(locked.root, root)


@pytest.mark.parametrize("step, least", [(0.5, 0.028), (0.05, 0.004), (0.0, -0.001)])
def test_a_dragged_foot_clears_the_floor(step, least):
    frames, swing = 40, slice(14, 26)
    root, quats = standing(frames)
    contacts = np.tile([0.0, 0, 0, 1, 1], (frames, 1))
    contacts[swing, 4] = 0
    # The left foot slides over the floor from one stance to the next while the body stays: its leg is turned.
    share = np.clip((np.arange(frames) - 13) / 13, 0, 1) - 0.5
    angle = np.arctan(step * share / 0.83)
    half = np.stack([np.cos(-angle / 2), np.sin(-angle / 2), 0 * angle, 0 * angle], -1)
    quats[:, skeleton.INDEX["left_hip"]] = rotation.multiply(half, quats[:, skeleton.INDEX["left_hip"]])
    locked = lock_feet(Motion(root, quats, contacts=contacts))
    positions, globals_ = locked.forward_kinematics()
    heel, ball = sole_points(positions, globals_, REST, "left")
    toes = toe_tips(positions, globals_, REST, "left")
    lowest = np.min([heel[:, 1], ball[:, 1], toes[:, 1]], axis=0)
    assert lowest[19:21].min() > least
    assert np.abs(np.diff(positions[:, skeleton.INDEX["left_foot"], 1])).max() < 0.02, "the foot does not pop"
    assert np.abs(np.minimum(heel, ball)[:12, 1]).max() < 2e-3, "stances stay on the floor"


def test_toes_bend_where_a_heel_rises():
    frames = 20
    root, quats = standing(frames)
    angle = np.radians(np.linspace(0, 35, frames))
    half = np.stack([np.cos(angle / 2), np.sin(angle / 2), 0 * angle, 0 * angle], -1)
    ankle = skeleton.INDEX["left_ankle"]
    quats[:, ankle] = rotation.multiply(half, quats[:, ankle])
    contacts = np.tile([0.0, 0, 0, 1, 1], (frames, 1))
    locked = lock_feet(Motion(root, quats, contacts=contacts))
    positions, globals_ = locked.forward_kinematics()
    assert toe_tips(positions, globals_, REST, "left")[:, 1].min() > -0.004
    assert sole_points(positions, globals_, REST, "left")[1][:, 1].max() < 0.01, "the ball stays down"
    assert np.allclose(np.abs(locked.rotations[:, skeleton.INDEX["right_foot"], 0]), 1, atol=1e-6)


def test_a_body_is_put_on_the_floor():
    root, quats = standing(60)
    floor = np.full(60, 0.3)
    motion = Motion(root + np.linspace(-0.1, 0.2, 60)[:, None] * [0.0, 1.0, 0.0], quats)
    np.testing.assert_allclose(lowest_sole(grounded(motion, floor)), floor, atol=0.03)
    assert grounded(motion, floor, 1.0).root.tolist() == motion.root.tolist()


@pytest.mark.parametrize(("settings", "rises"), [(replace(LABELLED, steps=False), True), (FOUND, False)])
def test_feet_that_both_swing_may_carry_the_body(settings, rises):
    root, quats = standing(60)
    contacts = np.zeros((60, 5))
    contacts[:10, 3:] = contacts[-10:, 3:] = 1
    steps = np.clip((np.arange(60) - 10) / 40, 0, 1)
    motion = Motion(root + steps[:, None] * [0.0, 0.0, 0.6], quats, contacts=contacts)
    height = lowest_sole(lock_feet(motion, 0.0, settings))[25:35].min()
    assert bool(height > 0.02) == rises
