"""Trunks of lying bodies are raised onto the back of a lounger."""

import numpy as np
import pytest
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.methods.samp.finishing.raised_back import raise_trunk
from samp_blender.samp_addon.motion import Motion

GOAL = np.array([0.3, 0.5, -0.2, 0.0, 0.0, 1.0, 0, 0, 0, 0, 1.0])
FRAMES = 40


def lying(pitch, yaw=0.0, away=0.0):
    """Return a held pose whose trunk leans back by an angle from upright, radians, the head towards -Z."""
    quats = np.zeros((FRAMES, 22, 4))
    quats[..., 0] = 1
    lean = rotation.from_axis_angle(np.array([-pitch, 0.0, 0.0]))
    quats[:, 0] = rotation.multiply(rotation.about_y(np.array(yaw)), lean)
    return Motion(np.tile(GOAL[:3] + [away, 0, 0], (FRAMES, 1)), quats)


def elevation(motion):
    joints = motion.forward_kinematics()[0]
    trunk = joints[:, skeleton.INDEX["neck"]] - joints[:, 0]
    return np.arcsin(trunk[:, 1] / np.linalg.norm(trunk, axis=-1))


@pytest.mark.parametrize("angle", np.radians([20, 35, 50]))
def test_a_flat_trunk_is_raised_and_the_legs_stay(angle):
    before = lying(np.pi / 2)
    after = raise_trunk(before, GOAL, angle)
    assert elevation(after) == pytest.approx(angle, abs=0.01)
    legs = [skeleton.INDEX[name] for name in ("left_hip", "right_hip", "left_knee", "right_knee")]
    old, new = (motion.forward_kinematics()[1][:, legs] for motion in (before, after))
    assert np.abs((old * new).sum(-1)) == pytest.approx(1)
    assert np.array_equal(before.root, after.root)


@pytest.mark.parametrize(
    "motion",
    [lying(0.2), lying(np.radians(50)), lying(np.pi / 2, yaw=np.pi), lying(np.pi / 2, away=2.0)],
    ids=["upright", "steeper than the back", "head at the foot end", "elsewhere"],
)
def test_other_trunks_do_not_change(motion):
    assert raise_trunk(motion, GOAL, np.radians(35)) is motion
