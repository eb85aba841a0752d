"""The front of a seat: shins that stay out of it."""

import numpy as np
import pytest
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.methods.samp.finishing.seat_edge import SHIN, SeatFront
from samp_blender.samp_addon.motion import Goal, Motion
from samp_blender.samp_addon.scene.geometry import sample_surface
from shapes import box

GOAL = Goal(np.array([0.0, 0.43 + 0.18, 0.0]), np.array([0.0, 0.0, 1.0]))
ROW = np.concatenate([GOAL.position, GOAL.direction, [0, 0, 0, 1, 0]])
FRAMES = 40


def front(piece, floor=0.0):
    points, _ = sample_surface(piece, 20000, seed=0)
    return SeatFront.of(points, Goal(GOAL.position + [0, floor, 0], GOAL.direction), floor)


def seated(tuck):
    """A body on GOAL with level thighs and its shins turned back by ``tuck`` degrees."""
    quats = np.zeros((FRAMES, 22, 4))
    quats[..., 0] = 1
    for side in ("left", "right"):
        quats[:, skeleton.INDEX[f"{side}_hip"]] = about_x(-80)
        quats[:, skeleton.INDEX[f"{side}_knee"]] = about_x(80 + tuck)
    return Motion(np.tile(GOAL.position, (FRAMES, 1)), quats)


def about_x(degrees):
    half = np.radians(degrees) / 2
    return np.array([np.cos(half), np.sin(half), 0.0, 0.0])


def shin_ahead(motion, share):
    """Return how far (T, 2) the shins are in front of the goal, at a share of the way from ankle to knee."""
    positions, _ = motion.forward_kinematics()
    at = lambda name: positions[:, [skeleton.INDEX[f"left_{name}"], skeleton.INDEX[f"right_{name}"]], 2]
    return at("ankle") + share * (at("knee") - at("ankle"))


@pytest.mark.parametrize("floor", [0.0, 1.2])
def test_a_sofa_is_closed_down_to_the_floor_and_a_stool_is_open(floor):
    up = np.array([0.0, floor, 0.0])
    closed = front(box((-0.5, 0.0, -0.5), (0.5, 0.43, 0.3)) + up, floor)
    stool = front(box((-0.5, 0.38, -0.5), (0.5, 0.43, 0.3)) + up, floor)
    assert np.allclose(closed.edge, 0.3, atol=0.02)
    assert (stool.edge[stool.heights < 0.3] == -np.inf).all()


@pytest.mark.parametrize("tuck", [10, 25])
def test_tucked_feet_come_out_of_a_sofa(tuck):
    sofa = front(box((-0.5, 0.0, -0.5), (0.5, 0.43, 0.3)))
    before = seated(tuck)
    assert shin_ahead(before, 0.2).min() < 0.3 + SHIN - 0.02, "else there is nothing to correct"
    after = sofa.clear_shins(before, ROW, np.zeros(FRAMES))
    assert shin_ahead(after, 0.2).min() > 0.3 + SHIN - 0.01
    joints = after.forward_kinematics()[0]
    assert np.allclose(joints[:, 0], before.root)
    assert np.isfinite(after.rotations).all()
    assert np.allclose(np.linalg.norm(after.rotations, axis=-1), 1)


def test_a_standing_body_comes_out_of_a_sofa_with_its_feet():
    """If its feet were moved alone, it would lean back over them."""
    sofa = front(box((-0.5, 0.0, -0.5), (0.5, 0.43, 0.3)))
    quats = np.zeros((FRAMES, 22, 4))
    quats[..., 0] = 1
    before = Motion(np.tile([0.0, 0.95, 0.2], (FRAMES, 1)), quats)
    after = sofa.clear_shins(before, ROW, np.ones(FRAMES))
    assert shin_ahead(after, 0.2).min() > 0.3 + SHIN - 0.01
    over = lambda motion: motion.root[:, 2] - shin_ahead(motion, 0.0).mean(1)
    np.testing.assert_allclose(over(after), over(before), atol=0.01)


@pytest.mark.parametrize("where", ["stool", "afar", "turned away"])
def test_legs_with_room_stay_as_they_are(where):
    piece = front(box((-0.5, 0.38 if where == "stool" else 0.0, -0.5), (0.5, 0.43, 0.3)))
    motion, row = seated(25), ROW.copy()
    if where == "afar":
        row[2] -= 1.0
    if where == "turned away":
        turned = motion.rotations.copy()
        turned[:, 0] = rotation.about_y(np.radians(120))
        motion = Motion(motion.root, turned)
    assert np.array_equal(piece.clear_shins(motion, row, np.zeros(FRAMES)).rotations, motion.rotations)
