"""Posture of bodies whose angles are known: bent knees and elbows, leaning trunks, wide stances."""

import numpy as np
import pytest
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.evaluation import posture
from samp_blender.samp_addon.motion import Motion

FRAMES = 30


def body(speed=0.0, **turns):
    """Return a body at a speed, m/s; turns: degrees about the X axis of joints of both sides, or of the trunk."""
    rotations = np.zeros((FRAMES, 22, 4))
    rotations[..., 0] = 1
    for name, degrees in turns.items():
        for joint in (name, f"left_{name}", f"right_{name}"):
            if joint in skeleton.INDEX:
                axis = np.array([np.radians(degrees), 0.0, 0.0])
                rotations[:, skeleton.INDEX[joint]] = rotation.from_axis_angle(axis)
    root = np.tile([0.0, 0.95, 0.0], (FRAMES, 1))
    root[:, 2] = speed * np.arange(FRAMES) / 30
    return Motion(root, rotations)


@pytest.mark.parametrize(
    ("motion", "phase"),
    [(body(), "idle"), (body(1.2), "walk"), (body(hip=-90, knee=90), "seated"), (body(0.3), None)],
)
def test_each_frame_is_in_the_phase_that_it_shows(motion, phase):
    found = {name for name, flags in posture.phases(motion).items() if flags.all()}
    assert found == ({phase} if phase else set())


def test_bent_knees_are_as_bent_as_they_were_made():
    straight, bent, more = (posture.measures(body(knee=knee)) for knee in (0.0, 30.0, 45.0))
    assert more["idle_knee_deg"] - bent["idle_knee_deg"] == pytest.approx(15, abs=1)
    assert bent["idle_knee_deg"] > straight["idle_knee_deg"] + 15
    assert bent["idle_straight_deg"] == pytest.approx(bent["idle_knee_deg"], abs=1)


@pytest.mark.parametrize("lean", [-10.0, 0.0, 25.0])
def test_a_lean_is_forward_of_vertical(lean):
    rest, found = posture.measures(body()), posture.measures(body(pelvis=lean))
    for part in ("lower_trunk", "upper_trunk", "neck"):
        assert found[f"idle_{part}_deg"] == pytest.approx(rest[f"idle_{part}_deg"] + lean, abs=0.5)


def test_a_neck_that_leans_leaves_the_trunk_as_it_is():
    rest, found = posture.measures(body()), posture.measures(body(neck=20))
    assert found["idle_neck_deg"] == pytest.approx(rest["idle_neck_deg"] + 20, abs=1)
    assert found["idle_lower_trunk_deg"] == rest["idle_lower_trunk_deg"]


def test_the_width_of_a_stance_is_sideways_only():
    apart = posture.measures(body())["idle_step_width_m"]
    joints = body().forward_kinematics()[0][0]
    sideways = abs(joints[skeleton.INDEX["left_ankle"], 0] - joints[skeleton.INDEX["right_ankle"], 0])
    assert apart == pytest.approx(sideways, abs=1e-3)


def test_a_phase_of_a_few_frames_is_left_out():
    short = body().pose_slice(slice(0, posture.LEAST_FRAMES - 1))
    assert posture.measures(short) == {}
