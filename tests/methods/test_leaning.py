"""Seated bodies lean on the back of their seat, lay down their hands, and cross their ankles, as their posture asks."""

from dataclasses import replace

import numpy as np
import pytest
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.evaluation import rest_posture
from samp_blender.samp_addon.frames import yaw_direction
from samp_blender.samp_addon.methods.samp import posture_places
from samp_blender.samp_addon.methods.samp.finishing import crossing, hands, leaning
from samp_blender.samp_addon.methods.samp.finishing.leaning import MOST, UPRIGHT_MOST, SeatBack, leaned
from samp_blender.samp_addon.methods.samp.finishing.resting import RestingTop
from samp_blender.samp_addon.motion import Goal, Motion
from samp_blender.samp_addon.scene.geometry import sample_surface
from shapes import box

FRAMES, DOWN = 90, 20
PLACE = np.array([0.4, 0.6, -0.3])


def about_x(degrees):
    half = np.radians(degrees) / 2
    return np.array([np.cos(half), np.sin(half), 0.0, 0.0])


def seated(yaw=0.0, arms=0.0):
    """Return an upright body with level thighs at PLACE. arms: degrees from hanging to raised forward."""
    quats = np.zeros((FRAMES, 22, 4))
    quats[..., 0] = 1
    quats[:, 0] = rotation.about_y(np.array(yaw))
    for side, sign in (("left", -1), ("right", 1)):
        quats[:, skeleton.INDEX[f"{side}_hip"]] = about_x(-80)
        quats[:, skeleton.INDEX[f"{side}_knee"]] = about_x(80)
        hang = rotation.from_axis_angle(np.array([0.0, 0.0, sign * np.radians(75)]))
        quats[:, skeleton.INDEX[f"{side}_shoulder"]] = rotation.multiply(about_x(-arms), hang)
        quats[:, skeleton.INDEX[f"{side}_elbow"]] = rotation.from_axis_angle(np.array([0.0, sign * 0.5, 0.0]))
    return Motion(np.tile(PLACE, (FRAMES, 1)), quats)


def row(yaw):
    return np.concatenate([PLACE, yaw_direction(yaw), [0, 0, 0, 1, 0]])


def chair(gap, yaw):
    """Return points of a back so far behind the pelvis, metres, and the goal in front of it."""
    points, _ = sample_surface(box((-0.3, 0.5, -gap - 0.1), (0.3, 1.2, -gap)), 30000, seed=0)
    points = rotation.rotate(np.broadcast_to(rotation.about_y(np.array(yaw)), (len(points), 4)), points)
    return points + [PLACE[0], 0, PLACE[2]], Goal(PLACE, yaw_direction(yaw), "sit")


@pytest.mark.parametrize("yaw", [0.0, 2.0])
@pytest.mark.parametrize("gap", [0.2, 0.26])
def test_the_back_comes_to_rest_and_legs_and_hands_stay(gap, yaw):
    points, goal = chair(gap, yaw)
    before = seated(yaw)
    after = SeatBack.of(points, goal).leaned_on(before, row(yaw), DOWN)
    assert rest_posture.back_gap(before, FRAMES - 1, points) > rest_posture.TOUCHING_BACK
    assert rest_posture.back_gap(after, FRAMES - 1, points) < rest_posture.TOUCHING_BACK
    assert rest_posture.flags(after, "sit")["lean_back"][-1]
    old, new = before.forward_kinematics()[0], after.forward_kinematics()[0]
    still = [skeleton.INDEX[f"{s}_{n}"] for s in ("left", "right") for n in ("hip", "knee", "ankle", "wrist")]
    assert np.abs(old[:, still] - new[:, still]).max() < 0.02
    assert np.allclose(old[:5], new[:5])


@pytest.mark.parametrize(
    "gap, most, down", [(0.48, MOST, DOWN), (0.26, UPRIGHT_MOST, DOWN), (0.2, MOST, FRAMES - 5)]
)
def test_nothing_changes_out_of_reach_or_without_time(gap, most, down):
    points, goal = chair(gap, 0.0)
    before = seated()
    assert SeatBack.of(points, goal, most).leaned_on(before, row(0.0), down) is before


def test_a_stool_has_no_back():
    points, _ = sample_surface(box((0.2, 0.0, -0.5), (0.6, 0.42, -0.1)), 20000, seed=0)
    assert SeatBack.of(points, Goal(PLACE, yaw_direction(0.0), "sit")) is None


def test_the_whole_body_turns_by_the_angle():
    after = leaned(seated(), yaw_direction(0.0), np.full(FRAMES, np.radians(20.0)))
    joints = after.forward_kinematics()[0][-1]
    trunk = joints[skeleton.INDEX["neck"]] - joints[skeleton.INDEX["spine2"]]
    straight = seated().forward_kinematics()[0][-1]
    upright = straight[skeleton.INDEX["neck"]] - straight[skeleton.INDEX["spine2"]]
    apart = np.degrees(np.arccos(trunk @ upright / np.linalg.norm(trunk) / np.linalg.norm(upright)))
    assert apart == pytest.approx(20, abs=1)


@pytest.mark.parametrize(
    "arms, posture, lowered",
    [
        (90, (), True),
        (90, ("hands_on_table",), False),
        (0, (), False),
        (0, ("hands_on_lap",), True),
    ],
)
def test_hands_on_the_lap(arms, posture, lowered):
    before = seated(arms=arms)
    after = hands.rested(before, row(0.0), DOWN, posture, None)
    assert rest_posture.flags(after, "sit")["hands_on_lap"][-1] == lowered
    assert (after.rotations == before.rotations).all() != lowered
    assert np.allclose(after.rotations[:10], before.rotations[:10], atol=1e-6)


@pytest.mark.parametrize("ahead, stoops", [(0.3, False), (0.5, True)])
def test_hands_on_a_table(ahead, stoops):
    """Wrists end on the table, over its edge; for one that is far the trunk turns forward too."""
    before = seated()
    table = PLACE + np.array([[0.17, 0.2, ahead], [-0.17, 0.2, ahead]])
    after = hands.rested(before, row(0.0), DOWN, ("hands_on_table",), None, table)
    joints = after.forward_kinematics()[0]
    wrists = joints[:, [skeleton.INDEX["left_wrist"], skeleton.INDEX["right_wrist"]]]
    assert wrists[-1] == pytest.approx(table, abs=0.01)
    assert rest_posture.flags(after, "sit")["hands_on_table"][-1]
    over = wrists[..., 2] > PLACE[2] + ahead - posture_places.FROM_EDGE
    assert (wrists[..., 1][over] > table[0, 1] - posture_places.WRIST).all()
    neck = (
        joints[-1, skeleton.INDEX["neck"], 2] - before.forward_kinematics()[0][-1, skeleton.INDEX["neck"], 2]
    )
    assert (neck > 0.03) == stoops
    assert np.allclose(after.rotations[:10], before.rotations[:10], atol=1e-6)


@pytest.mark.parametrize("arms", [(0.2, 0.28), None])
def test_hands_on_armrests(arms):
    parts = [box((-0.3, 0.0, -0.3), (0.3, 0.42, 0.3))]
    if arms:
        parts += [box((x0, 0.42, -0.3), (x1, 0.64, 0.3)) for x0, x1 in (arms, (-arms[1], -arms[0]))]
    points, _ = sample_surface(np.concatenate(parts) + [PLACE[0], 0, PLACE[2]], 30000, seed=0)
    goal = Goal(PLACE, yaw_direction(0.0), "sit")
    top = RestingTop.of(points, goal, 0.0)
    before = seated(arms=40)
    after = hands.rested(before, row(0.0), DOWN, ("hands_on_armrests",), top)
    assert rest_posture.flags(after, "sit")["hands_on_armrests"][-1] == bool(arms)
    if arms:
        wrists = after.forward_kinematics()[0][
            -1, [skeleton.INDEX["left_wrist"], skeleton.INDEX["right_wrist"]]
        ]
        assert wrists[:, 1] == pytest.approx(0.64 + hands.WRIST, abs=0.02)
    else:
        assert (after.rotations == before.rotations).all()


def test_ankles_are_crossed_once():
    before = replace(seated(), contacts=np.ones((FRAMES, 5)))
    after = crossing.crossed(before, row(0.0), DOWN)
    crossed = rest_posture.flags(after, "sit")["legs_crossed"]
    assert not crossed[: DOWN + crossing.DELAY].any() and crossed[-1]
    joints = after.forward_kinematics()[0]
    step = np.diff(joints[:, skeleton.INDEX["right_ankle"]], axis=0)
    assert np.linalg.norm(step, axis=-1).max() < 0.05
    assert (after.contacts == 0).any(0).sum() == 1  # one foot leaves the floor
    again = crossing.crossed(after, row(0.0), 0)
    assert again is after


def test_upright_means_the_same_as_in_the_evaluation():
    assert np.degrees(leaning.STILL_UPRIGHT) == pytest.approx(rest_posture.LEANING)
