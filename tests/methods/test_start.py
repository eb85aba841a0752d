"""The state in which a rollout starts: standing at a given place, or continuing a motion."""

import numpy as np
import pytest
import torch
from samp_blender.models import state
from samp_blender.samp_addon import rotation
from samp_blender.samp_addon.methods.samp.rollout.start import SPAN, Start
from samp_blender.samp_addon.motion import Motion

FRAMES, SPEED, YAW = 40, 1.2, 0.7


def pose():
    quats = np.zeros((22, 4))
    quats[:, 0] = 1
    quats[0] = rotation.about_y(2.0)
    return quats


@pytest.mark.parametrize("yaw", [0.0, 1.3, -3.0])
def test_a_standing_start_is_at_its_root(yaw):
    start = Start.standing(0.93, pose(), np.array([1.0, 2.0, yaw]))
    assert torch.allclose(start.joints[0], torch.tensor([1.0, 0.93, 2.0]))
    off = float(state.heading_yaw(start.joints)) - yaw
    assert abs((off + np.pi) % (2 * np.pi) - np.pi) < 1e-4
    assert (start.velocities == 0).all() and start.roots.shape == (SPAN, 3)


def glide(floor=0.0):
    way = np.arange(FRAMES) / 30 * SPEED
    root = np.stack([way * np.sin(YAW), np.full(FRAMES, 0.93 + floor), way * np.cos(YAW)], -1)
    quats = np.tile(pose(), (FRAMES, 1, 1))
    quats[:, 0] = rotation.about_y(YAW)
    actions, contacts = np.tile(np.eye(5)[1], (FRAMES, 1)), np.tile([0.0, 0, 0, 1, 0], (FRAMES, 1))
    return Motion(root, quats, actions=actions, contacts=contacts)


@pytest.mark.parametrize("floor", [0.0, 2.5])
def test_a_walk_is_continued(floor):
    motion = glide(floor)
    start = Start.after(motion, floor)
    assert np.allclose(start.joints[0], motion.root[-1] - [0, floor, 0], atol=1e-5)
    assert np.allclose(start.velocities[0], [SPEED * np.sin(YAW), 0, SPEED * np.cos(YAW)], atol=1e-3)
    assert np.allclose(start.roots[:, 2], YAW, atol=1e-4)
    assert np.allclose(start.roots[:, :2], motion.root[-SPAN:, [0, 2]], atol=1e-5)
    assert np.allclose(start.actions, np.eye(5)[1])


def test_before_a_short_motion_its_first_frame_is_repeated():
    motion = glide()
    short = Motion(
        motion.root[:3], motion.rotations[:3], actions=motion.actions[:3], contacts=motion.contacts[:3]
    )
    roots = Start.after(short).roots
    assert np.allclose(roots[: SPAN - 3], roots[0]) and not np.allclose(roots[-1], roots[0])


def test_a_motion_without_contacts_cannot_be_continued():
    motion = glide()
    with pytest.raises(ValueError, match="contacts"):
        Start.after(Motion(motion.root, motion.rotations))
