"""The head of a take is turned to a target, within the limits of its joints."""

from __future__ import annotations

import numpy as np
import pytest
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.body.joint_limits import limits
from samp_blender.samp_addon.edits.look_at import EASE, look_at
from samp_blender.samp_addon.motion import Motion

HEAD, NECK = skeleton.INDEX["head"], skeleton.INDEX["neck"]
EYES = [skeleton.INDEX[f"{side}_eye_smplhf"] for side in ("left", "right")]


def _standing(count=90, yaw=0.0):
    rotations = np.zeros((count, 22, 4))
    rotations[..., 0] = 1
    rotations[:, 0] = rotation.about_y(yaw)
    return Motion(np.tile([1.0, 0.95, 2.0], (count, 1)), rotations)


def _miss(motion, target):
    """Degrees between the face and the direction from the eyes to the target, in each frame."""
    joints, globals_ = motion.forward_kinematics()
    face = rotation.rotate(globals_[:, HEAD], np.array([0.0, 0.0, 1.0]))
    wanted = target - joints[:, EYES].mean(1)
    cosine = (face * wanted).sum(-1) / np.linalg.norm(wanted, axis=-1)
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


@pytest.mark.parametrize(
    ("side", "up", "most"),
    [(0, 0, 2), (40, 0, 2), (-60, 10, 3), (30, -30, 3), (20, 30, 3), (90, 0, 17), (-100, 0, 27)],
)
@pytest.mark.parametrize("yaw", [0.0, 2.0])
def test_the_face_turns_to_the_target(side, up, most, yaw):
    motion = _standing(yaw=yaw)
    angle, height = np.radians(side) + yaw, np.radians(up)
    eyes = motion.forward_kinematics()[0][0]
    looked = look_at(motion, np.zeros(3))
    eyes = looked.forward_kinematics()[0][0, EYES].mean(0)
    target = eyes + 3 * np.array(
        [np.sin(angle) * np.cos(height), np.sin(height), np.cos(angle) * np.cos(height)]
    )
    assert _miss(look_at(motion, target), target)[-1] < most


def test_only_the_range_changes_and_it_eases():
    motion, target = _standing(), np.array([3.0, 1.5, 3.0])
    looked = look_at(motion, target, 20, 70)
    turned = np.degrees(
        np.linalg.norm(rotation.to_axis_angle(looked.rotations[:, [NECK, HEAD]]), axis=-1).sum(1)
    )
    assert turned[:20].max() == 0 and turned[71:].max() == 0
    assert turned[20 + round(EASE * 30) + 5] > 25
    assert np.abs(np.diff(turned)).max() < 7  # degrees from one frame to the next
    others = [j for j in range(22) if j not in (NECK, HEAD)]
    assert np.array_equal(looked.rotations[:, others], motion.rotations[:, others])
    assert np.array_equal(looked.root, motion.root)


def test_joint_limits_hold_and_a_target_behind_is_given_up():
    motion = _standing()
    circle = np.linspace(0, 2 * np.pi, 90)
    target = motion.root + np.stack([2 * np.sin(circle), np.full(90, 0.6), 2 * np.cos(circle)], -1)
    looked = look_at(motion, target)
    angles = np.linalg.norm(rotation.to_axis_angle(looked.rotations[:, :22]), axis=-1)
    assert (angles <= limits()[:22] + 1e-6).all()
    assert angles[45, HEAD] + angles[45, NECK] < np.radians(12)  # right behind
    steps = np.linalg.norm(np.diff(rotation.to_axis_angle(looked.rotations[:, HEAD]), axis=0), axis=-1)
    assert np.degrees(steps).max() < 8


def test_an_empty_range_is_refused():
    with pytest.raises(ValueError, match="empty"):
        look_at(_standing(10), np.zeros(3), 8, 5)
