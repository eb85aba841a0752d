"""Takes for bodies of other proportions: feet on the floor, the pelvis as high over its seat as the body is thick."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.body import body_shape, human
from samp_blender.samp_addon.easing import smoothstep
from samp_blender.samp_addon.methods.take import SubGoal, Take
from samp_blender.samp_addon.motion import Goal, Motion
from samp_blender.samp_addon.pipeline import other_body
from samp_blender.samp_addon.refine.feet.foot import FEET
from samp_blender.samp_addon.refine.inverse_kinematics import solve_limb
from samp_blender.samp_addon.refine.proportions import heels, hips

STANDS, ALL = 30, 90
BODIES = (
    {"height": 1.55, "weight": 45, "gender": 0},
    {"height": 1.55, "weight": 64},
    {"height": 1.75},
    {"height": 1.95, "weight": 80, "gender": 1},
    {"height": 1.95, "weight": 115, "gender": 1},
)


@cache
def take():
    """Return a take of the default human that stands, and sits down onto a seat of 45 cm behind it."""
    body = human.load()
    share = smoothstep((np.arange(ALL) - STANDS) / 30)
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (ALL, 22, 1))
    for side in ("left", "right"):
        for name, degrees in (("hip", -85.0), ("knee", 80.0)):
            bend = np.outer(np.radians(8 + share * (abs(degrees) - 8)) * np.sign(degrees), [1.0, 0.0, 0.0])
            rotations[:, skeleton.INDEX[f"{side}_{name}"]] = rotation.from_axis_angle(bend)
    root = np.zeros((ALL, 3))
    root[:, 1] = (1 - share) * (-body.floor - 0.01) + share * 0.63
    root[:, 2] = -0.42 * share
    for side, across in (("left", 0.1), ("right", -0.1)):
        ankle = skeleton.INDEX[f"{side}_ankle"]
        there = np.tile([across, body.joints[ankle, 1] - body.floor, 0.0], (ALL, 1))
        rotations = solve_limb(root, rotations, body.joints, f"{side}_leg", there)
        _, globals_ = skeleton.forward_kinematics(root, rotations, body.joints)
        knee = globals_[:, skeleton.INDEX[f"{side}_knee"]]
        rotations[:, ankle] = rotation.conjugate(knee)  # the foot is level
    contacts = np.zeros((ALL, 5))
    contacts[:, 0], contacts[:, 3:] = share > 0.95, 1
    motion = Motion(root, rotations, contacts=contacts)
    goal = Goal(root[-1], np.array([0.0, 0.0, 1.0]), "sit")
    return Take(1, motion, goal=goal, sub_goals=(SubGoal(root[0], goal.direction, 0),))


@pytest.mark.parametrize("measures", BODIES, ids=str)
def test_feet_stand_and_hips_are_over_the_seat(measures):
    body = human.load().shaped(body_shape.shapes(measures))
    made = other_body.fitted(take(), body)
    np.testing.assert_allclose(made.motion.rest_joints, body.joints)
    lowest = human.skin(body, made.motion)[..., 1].min(1)
    assert np.abs(lowest[[0, STANDS, -1]]).max() < 0.02
    assert np.abs(lowest).max() < 0.03
    before, after = (hips.hips(t.motion.forward_kinematics()[0]) for t in (take(), made))
    thicker = [hips.seat_depth(b.vertices, b.joints) for b in (human.load(), body)]
    assert (after - before)[-1, 1] == pytest.approx(thicker[1] - thicker[0], abs=0.005)
    taller = body.floor / human.load().floor
    assert after[0, 1] == pytest.approx(taller * before[0, 1], abs=0.03)
    # The goal is where the pelvis of this body is, at most a few centimetres from the first one.
    np.testing.assert_allclose(made.goal.position, made.motion.root[-1])
    np.testing.assert_allclose(made.sub_goals[0].position, made.motion.root[0])
    assert np.linalg.norm((made.goal.position - take().goal.position)[[0, 2]]) < 0.06


def test_short_thighs_come_forward():
    body = human.load().shaped(body_shape.shapes({"height": 1.55}))
    made = other_body.fitted(take(), body)
    before, after = (hips.hips(t.motion.forward_kinematics()[0]) for t in (take(), made))
    assert 0.015 < (after - before)[-1, 2] < 0.06 and abs((after - before)[0, 2]) < 0.005


def knees_below_hips(motion):
    positions, _ = motion.forward_kinematics()
    return hips.hips(positions)[-1, 1] - positions[-1, [foot.knee for foot in FEET], 1]


@pytest.mark.parametrize("measures", BODIES[:2], ids=str)
def test_heels_rise_where_shins_are_too_short_for_the_seat(measures):
    body = human.load().shaped(body_shape.shapes(measures))
    made = other_body.fitted(take(), body)
    positions, _ = made.motion.forward_kinematics()
    drop = knees_below_hips(take().motion) - knees_below_hips(made.motion)
    assert (drop > 0.0).all() and (drop < 0.03).all()
    for foot in FEET:
        ankle, ball = positions[:, foot.ankle, 1], positions[:, foot.ball, 1]
        assert 0.01 < ankle[-1] - ankle[0] < heels.MOST + 0.01
        assert abs(ball[-1] - ball[0]) < 0.01


def test_tall_bodies_keep_their_heels_down():
    body = human.load().shaped(body_shape.shapes({"height": 1.95}))
    positions, _ = other_body.fitted(take(), body).motion.forward_kinematics()
    for foot in FEET:
        assert abs(positions[-1, foot.ankle, 1] - positions[0, foot.ankle, 1]) < 0.01


def test_a_take_of_the_body_stays_as_it_is():
    assert other_body.fitted(take(), human.load()) is take()
