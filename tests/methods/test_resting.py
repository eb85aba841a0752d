"""Limbs are moved out of mattresses, pillows, armrests and backs."""

import numpy as np
import pytest
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.methods.samp.finishing.resting import GIVE, RestingTop, bone_end
from samp_blender.samp_addon.motion import Goal, Motion
from samp_blender.samp_addon.scene.geometry import sample_surface
from samp_blender.samp_addon.scene.seats.postures import BED_TO_PELVIS, SEAT_TO_PELVIS
from shapes import box

FRAMES, SEAT, MATTRESS = 40, 0.45, 0.5
SIT = Goal(np.array([0.0, SEAT + SEAT_TO_PELVIS, 0.0]), np.array([0.0, 0.0, 1.0]), "sit")
LIE = Goal(np.array([0.0, MATTRESS + BED_TO_PELVIS, 0.0]), np.array([0.0, 0.0, 1.0]), "lie")
BED = box((-0.6, 0.0, -1.0), (0.6, MATTRESS, 1.0))
BENCH = box((-1.0, 0.0, -0.3), (1.0, SEAT, 0.3))


def row(goal):
    return np.concatenate([goal.position, goal.direction, np.zeros(5)])


def turned(joint_angles):
    """Return local rotations (22, 4) with some joints turned by degrees about x, y or z."""
    quats = np.zeros((22, 4))
    quats[:, 0] = 1
    for joint, axis, degrees in joint_angles:
        quats[skeleton.INDEX[joint]] = rotation.from_axis_angle(
            np.radians(degrees) * np.eye(3)["xyz".index(axis)]
        )
    return quats


HANGING = (("left_shoulder", "z", -75), ("right_shoulder", "z", 75))
SITTING = (("left_hip", "x", -85), ("right_hip", "x", -85), ("left_knee", "x", 85), ("right_knee", "x", 85), *HANGING,
           ("left_elbow", "y", -70), ("right_elbow", "y", 70))  # fmt: skip
LEGS_OUT = (("left_hip", "x", -95), ("right_hip", "x", -95), *HANGING)
LYING = (("pelvis", "x", -90), *HANGING)


def held(goal, pose, shift=(0.0, 0.0, 0.0)):
    place = goal.position + np.array(shift)
    return Motion(np.tile(place, (FRAMES, 1)), np.tile(turned(pose), (FRAMES, 1, 1)))


def top(mesh, goal, floor=0.0):
    moved = Goal(goal.position + [0, floor, 0], goal.direction, goal.action)
    return RestingTop.of(sample_surface(mesh + np.array([0.0, floor, 0.0]), 40000, seed=0)[0], moved, floor)


def joint(motion, name):
    return motion.forward_kinematics()[0][:, skeleton.INDEX[name]]


@pytest.mark.parametrize("floor", [0.0, 1.5])
def test_the_top_is_measured_over_the_floor(floor):
    found = top(BED, LIE, floor)
    places = np.array([[0.0, 0.0], [0.5, 0.9], [0.7, 0.0], [0.0, 1.2]])
    missing = found.missing(np.column_stack([places[:, 0], np.full(4, MATTRESS - 0.02), places[:, 1]]), 0.03)
    assert np.allclose(missing, [0.05, 0.05, 0, 0], atol=0.01)


def test_a_body_on_top_is_left_as_it_is():
    motion = held(LIE, LYING, (0, 0.05, 0))
    assert top(BED, LIE).cleared(motion, row(LIE)) is motion


@pytest.mark.parametrize("depth", [0.04, 0.08])
def test_a_head_is_put_on_its_pillow(depth):
    motion = held(LIE, LYING, (0, 0.05, 0))
    head = joint(motion, "head")[0]
    pillow = box((-0.3, MATTRESS, head[2] - 0.3), (0.3, head[1] - 0.10 + depth, head[2] + 0.2))
    mended = top(np.concatenate([BED, pillow]), LIE).cleared(motion, row(LIE))
    assert joint(mended, "head")[FRAMES // 2, 1] == pytest.approx(head[1] + depth, abs=0.012)
    assert np.allclose(mended.root, motion.root)
    assert np.allclose(joint(mended, "left_ankle"), joint(motion, "left_ankle"))


def test_a_forearm_lies_on_the_armrest():
    motion = held(SIT, SITTING)
    wrist = joint(motion, "left_wrist")[0]
    rest = box((wrist[0] - 0.12, 0.0, -0.3), (wrist[0] + 0.3, wrist[1] + 0.02, 0.5))
    mended = top(np.concatenate([BENCH, rest]), SIT).cleared(motion, row(SIT))
    after = joint(mended, "left_wrist")[FRAMES // 2]
    on_it = after[1] > wrist[1] + 0.02 + 0.03 - 0.012
    beside_it = after[0] < wrist[0] - 0.12
    assert on_it or beside_it
    assert np.allclose(joint(mended, "right_wrist"), joint(motion, "right_wrist"))


def test_an_elbow_comes_out_of_the_back_of_a_sofa():
    motion = held(LIE, LYING, (0, 0.1, 0))
    elbow = joint(motion, "left_elbow")[0]
    back = box((elbow[0] - 0.06, 0.0, -1.0), (elbow[0] + 0.3, 1.0, 1.0))
    mended = top(np.concatenate([BED, back]), LIE).cleared(motion, row(LIE))
    assert joint(mended, "left_elbow")[FRAMES // 2, 0] < elbow[0] - 0.06


def test_hands_lie_flat():
    pose = (*LYING, ("left_wrist", "z", -60), ("right_wrist", "z", 60))
    motion = held(LIE, pose, (0, 0.03, 0))
    tip = lambda m: bone_end(m, "left_wrist", "left_middle2")[FRAMES // 2, 1]
    mended = top(BED, LIE).cleared(motion, row(LIE))
    assert tip(mended) >= min(tip(motion), MATTRESS + 0.01) - 1e-6 and tip(mended) > MATTRESS + 0.005


def test_limbs_are_corrected_without_a_pop():
    motion = held(LIE, LYING, (0, -0.03, 0))
    root = motion.root + np.array([0.0, 0.3, 0.0]) * np.clip(1 - np.arange(FRAMES) / 15, 0, 1)[:, None]
    motion = Motion(root, motion.rotations)
    mended = top(BED, LIE).cleared(motion, row(LIE))
    moved = mended.forward_kinematics()[0] - motion.forward_kinematics()[0]
    assert np.abs(moved).max() > 0.01, "else there is nothing to correct"
    assert np.linalg.norm(np.diff(moved, axis=0), axis=-1).max() < 0.025


@pytest.mark.parametrize("pose, thick", [(LYING, BED_TO_PELVIS), (LEGS_OUT, SEAT_TO_PELVIS)])
def test_a_pelvis_does_not_sink_into_the_mattress(pose, thick):
    motion = held(LIE, pose, (0.3, -0.05, 0))
    mended = top(BED, LIE).cleared(motion, row(LIE))
    assert mended.root[FRAMES // 2, 1] == pytest.approx(MATTRESS + thick - GIVE, abs=0.01)
    assert np.allclose(mended.root[:, [0, 2]], motion.root[:, [0, 2]])


@pytest.mark.parametrize("deep", [0.05, 0.15])
def test_shins_of_a_body_on_the_edge_are_in_front_of_it(deep):
    goal = Goal(LIE.position, np.array([1.0, 0.0, 0.0]), "lie")
    motion = held(goal, SITTING, (0, SEAT_TO_PELVIS - BED_TO_PELVIS, 0.0))
    shin = joint(motion, "left_ankle")[0, 2]
    bed = box((-1.0, 0.0, -0.8), (1.0, MATTRESS, shin + deep))
    mended = top(bed, goal).cleared(motion, row(goal))
    assert joint(mended, "left_ankle")[FRAMES // 2, 2] > shin + deep + 0.03
    assert joint(mended, "pelvis")[FRAMES // 2, 2] == pytest.approx(motion.root[0, 2] + deep + 0.06, abs=0.04)
    outside = top(box((-1.0, 0.0, -0.8), (1.0, MATTRESS, shin - 0.1)), goal)
    assert np.allclose(outside.cleared(motion, row(goal)).root[:, 2], motion.root[:, 2])


def test_a_leg_that_hangs_next_to_the_bed_is_left_as_it_is():
    # One knee is put onto the mattress in the last frames; nothing moves while the body still stands.
    standing = held(LIE, HANGING, (0.9, 0.3, 0))
    root = standing.root.copy()
    root[30:, 1] -= 0.32
    root[30:, 0] -= 0.75
    rotations = standing.rotations.copy()
    rotations[30:] = turned(LYING)
    motion = Motion(root, rotations)
    mended = top(BED, LIE).cleared(motion, row(LIE))
    before, after = (m.forward_kinematics()[0][:10] for m in (motion, mended))
    assert np.abs(mended.rotations[36] - motion.rotations[36]).max() > 1e-3, (
        "else there is nothing to correct"
    )
    assert np.abs(after - before).max() < 2e-3


@pytest.mark.parametrize("height, moves", [(0.93, True), (SEAT + SEAT_TO_PELVIS + 0.05, False)])
def test_bodies_that_stand_in_a_bench_are_moved_out_and_seated_ones_are_not(height, moves):
    """Legs 12 cm behind the bench's front edge."""
    motion = held(SIT, HANGING, (0.0, height - SIT.position[1], 0.18))
    cleared = top(BENCH, SIT).cleared(motion, row(SIT))
    forward = cleared.root[FRAMES // 2] - motion.root[FRAMES // 2]
    assert (forward[2] > 0.12) == moves and abs(forward[0]) < 0.02
    assert (forward[2] < 0.01) != moves
