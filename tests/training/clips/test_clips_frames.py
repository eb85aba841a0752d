"""Floor, foot lock, labels, pops and checks of retargeted clips, each on a motion that is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import recordings
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.evaluation import feet as measured
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.refine.feet.foot import toe_tips
from samp_blender.training.clips import feet, labels, quality

SEAT = (("left_hip", -85), ("right_hip", -85), ("left_knee", 85), ("right_knee", 85))


def posed(heights: np.ndarray, pose=(), speed: float = 0.0, tilt: np.ndarray | float = 0.0) -> Motion:
    """A pose (joint, degrees about X) with its pelvis at heights (T,), gliding forwards, m/s, tilted by degrees."""
    heights = np.asarray(heights, dtype=np.float64)
    vectors = np.zeros((len(heights), 22, 3))
    for joint, degrees in pose:
        vectors[:, skeleton.INDEX[joint], 0] = np.radians(degrees)
    vectors[:, 0, 0] = np.radians(tilt)
    root = np.stack([0 * heights, heights, speed * np.arange(len(heights)) / 30], -1)
    return Motion(root, rotation.from_axis_angle(vectors))


@pytest.mark.parametrize("height", [-0.7, 0.0, 0.4])
def test_the_floor_is_under_planted_feet(height):
    motion = recordings.walk(120)
    moved = replace(motion, root=motion.root + [0, height, 0])
    assert feet.floor_height(moved) == pytest.approx(height, abs=0.012)
    low = feet.soles(feet.grounded(moved))[..., 1].min(1)
    assert np.percentile(np.abs(low), 90) < 0.02


def test_a_lying_body_is_laid_on_the_floor():
    motion = posed(np.full(60, 0.3), tilt=-90.0)
    on_floor = feet.grounded(motion, np.ones(60, bool))
    assert np.abs(feet.lowest(on_floor)).max() < 0.01


def test_locked_feet_stand_and_nothing_else_moves_far():
    motion = recordings.walk(150)
    slid = replace(motion, root=motion.root * [1.0, 1.0, 1.06])  # feet slide with a twentieth of the speed
    contact = feet.touching(slid)
    made = feet.locked(slid, contact)
    before, after = measured.measures(slid), measured.measures(made)
    assert contact.any(0).all() and after["stance_share"] > 0.3
    assert after["stance_slide_cm_s"] < 0.5 * before["stance_slide_cm_s"]
    moved = np.linalg.norm(made.forward_kinematics()[0] - slid.forward_kinematics()[0], axis=-1)
    assert np.median(moved) < 0.02 and moved[:, : skeleton.INDEX["head"]].max() < 0.2
    assert feet.soles(made)[..., 1].min() > -0.01
    held = feet.settled(made, contact)
    assert (feet.flat_speed(feet.soles(made), 30.0)[held] < feet.SETTLED).all()


def test_toes_bend_out_of_the_floor_and_lie_flat():
    vectors = np.zeros((30, 22, 3))
    for side in ("left", "right"):
        vectors[:, skeleton.INDEX[f"{side}_ankle"], 0] = np.radians(30.0)
    local = rotation.from_axis_angle(vectors)
    root = np.tile([0.0, 0.0, 0.0], (30, 1))
    joints, _ = skeleton.forward_kinematics(root, local, recordings.REST)
    foot = feet.FEET[0]
    root[:, 1] = feet.BALL_HEIGHT - joints[:, foot.ball, 1]
    made = feet.flat_toes(root, local, recordings.REST, foot)
    joints, globals_ = skeleton.forward_kinematics(root, made, recordings.REST)
    assert np.abs(toe_tips(joints, globals_, recordings.REST, foot.side)[:, 1]).max() < 0.004
    bend = rotation.to_axis_angle(made[:, foot.ball])
    assert np.degrees(bend[15, 0]) == pytest.approx(-30.0, abs=4.0)


def steps(speed: float) -> Motion:
    return recordings.walk(150, speed=speed)


STANDS = np.full(90, 0.94)
DOWN = np.concatenate([np.full(40, 0.94), np.linspace(0.94, 0.52, 20), np.full(60, 0.52)])
LAID = np.concatenate([np.full(30, 0.94), np.linspace(0.94, 0.12, 40), np.full(60, 0.12)])
TIPPED = np.concatenate([np.zeros(30), np.linspace(0, -90, 40), np.full(60, -90)])


@pytest.mark.parametrize(
    "motion, text, main, among",
    [
        (posed(STANDS), "", "idle", ()),
        (posed(STANDS, speed=0.2), "", "shift", ()),
        (steps(1.1), "B3_Walk", "walk", ()),
        (posed(STANDS, speed=3.0), "C1 Run", "run", ()),
        (posed(STANDS, speed=3.0), "fastWalk", "walk", ()),
        (posed(STANDS - 0.3), "", "other", ()),
        (posed(STANDS + 0.2), "", "other", ()),
        (posed(DOWN, SEAT), "sit_down_chair", "sit", ("sit_down",)),
        (posed(DOWN[::-1], SEAT), "SitStandUp", "sit", ("stand_up",)),
        (posed(DOWN, SEAT), "squat", "other", ()),
        (posed(np.full(90, 0.52), SEAT), "sitting idle", "sit", ()),
        (posed(LAID, tilt=TIPPED), "", "lie", ("lie_down",)),
        (posed(LAID[::-1], tilt=TIPPED[::-1]), "", "lie", ("get_up",)),
    ],
)
def test_labels_by_name_height_and_speed(motion, text, main, among):
    contact = feet.touching(motion)
    found = labels.labelled(motion, contact, text)
    names, counts = np.unique(found, return_counts=True)
    assert names[counts.argmax()] == main
    assert set(among) <= set(names)
    assert set(names) <= set(labels.LABELS)


def test_pops_are_flagged_and_cut_off_near_the_ends():
    motion = recordings.walk(150)
    vectors = rotation.to_axis_angle(motion.rotations)
    for frame in (5, 80):
        vectors[frame, [0, 3, 16, 17], 0] += 0.9
    popped = replace(motion, rotations=rotation.from_axis_angle(vectors))
    flags = labels.pops(popped)
    assert not labels.pops(motion).any()
    assert flags[5] and flags[80] and not flags[20:70].any()
    part = labels.sound_part(flags)
    assert 5 < part.start < 15 and part.stop == 150 and flags[part].any()


@pytest.mark.parametrize(
    "joint, axis, degrees, beyond",
    [
        ("left_knee", 0, 150, False), ("left_knee", 0, -20, True), ("left_knee", 2, 40, True),
        ("left_elbow", 1, -150, False), ("left_elbow", 1, 40, True), ("right_elbow", 1, 150, False),
        ("left_elbow", 0, 80, False), ("left_wrist", 0, 90, True), ("right_wrist", 2, 80, False),
        ("head", 0, 60, True), ("left_hip", 0, -120, False), ("pelvis", 1, 170, False),
    ],
)  # fmt: skip
def test_joint_limits(joint, axis, degrees, beyond):
    vectors = np.zeros((3, 22, 3))
    vectors[1, skeleton.INDEX[joint], axis] = np.radians(degrees)
    assert quality.beyond_limits(rotation.from_axis_angle(vectors)).tolist() == [False, beyond, False]


def test_the_checks_of_a_set_name_a_crouch():
    walked, bent = quality.Quality(), quality.Quality()
    walked.add(recordings.walk(60), np.array(["walk"] * 60), np.zeros(60, bool))
    crouch = posed(np.full(60, 0.7), (("left_knee", 70), ("right_knee", 70)))
    bent.add(crouch, np.array(["idle"] * 60), np.zeros(60, bool))
    assert quality.faults({"knee idle": 15.0, "knee walk": 28.0, "knee straightest": None}) == []
    told = quality.faults(bent.numbers())
    assert len(told) == 2 and "knee idle" in told[0] and "knee straightest" in told[1]
    text = quality.table([("walk", walked.numbers()), ("bent", bent.numbers())])
    assert text.splitlines()[0] == "| measure | walk | bent |"
    assert len(text.splitlines()) == 2 + len(quality.COLUMNS)
    assert "| knee idle | - | 7" in text
