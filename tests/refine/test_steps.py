"""Bodies that glide over the floor make steps instead."""

from dataclasses import replace

import numpy as np
import pytest
from samp_blender.samp_addon import rotation
from samp_blender.samp_addon.evaluation import feet
from samp_blender.samp_addon.motion import Motion, velocities
from samp_blender.samp_addon.refine.feet import corrections, stances, steps
from samp_blender.samp_addon.refine.feet.foot import FEET
from samp_blender.samp_addon.refine.feet.foot_lock import LABELLED, lock_feet
from samp_blender.tests.refine.test_foot_lock import standing

BALLS = [foot.ball for foot in FEET]
ANKLES, KNEES, HIPS = ([getattr(foot, name) for foot in FEET] for name in ("ankle", "knee", "hip"))


def gliding(speed=0.6, turn=0.0, frames=90, bend=0.0):
    """A standing body that is moved along z, and turned by ``turn`` degrees in all; both feet are said to stand.

    bend: radians by which hips and knees are bent in addition.
    """
    root, quats = standing(frames)
    for joints, angle in ((HIPS, -bend), (KNEES, bend)):
        quats[:, joints] = rotation.multiply(quats[:, joints], rotation.from_axis_angle([angle, 0.0, 0.0]))
    share = np.clip((np.arange(frames) - 15) / (frames - 30), 0, 1)
    quats[:, 0] = rotation.multiply(rotation.about_y(np.radians(turn) * share), quats[:, 0])
    along = speed * (frames - 30) / 30 * share[:, None] * [0.0, 0.0, 1.0]
    return Motion(root + along, quats, contacts=np.ones((frames, 5)))


def speeds(motion):
    """Horizontal speeds (T, 2) of the balls of the feet."""
    balls = motion.forward_kinematics()[0][:, BALLS]
    return np.linalg.norm(velocities(balls[..., [0, 2]], motion.fps), axis=-1)


@pytest.mark.parametrize(("speed", "turn"), [(0.6, 0.0), (0.4, 150.0), (0.0, 170.0)])
def test_one_foot_stands_while_the_other_moves(speed, turn):
    motion = gliding(speed, turn)
    before, after = speeds(motion).min(1), speeds(lock_feet(motion)).min(1)
    assert after.mean() < 0.25 * before.mean()
    moved = speeds(lock_feet(motion)).max(0)
    assert (moved > 0.3).all(), "both feet make steps"


@pytest.mark.parametrize(
    "motion",
    [
        pytest.param(gliding(speed=0.0), id="stands"),
        pytest.param(gliding(speed=2.5), id="runs"),
        pytest.param(gliding(bend=1.3), id="seated"),
    ],
)
def test_other_bodies_keep_their_stances(motion):
    found = [[stances.Stance(0, 20), stances.Stance(30, 90)], [stances.Stance(5, 80)]]
    assert steps.stepping(motion, found) == found
    assert feet.measures(motion)["glide_s"] == 0


def test_glides_are_measured():
    motion = gliding()
    assert 1.5 < feet.measures(motion)["glide_s"] < 2.2
    assert feet.measures(lock_feet(motion))["glide_s"] == 0


def test_stances_outside_a_glide_are_kept_and_do_not_overlap():
    motion = gliding()
    found = steps.stepping(motion, [[stances.Stance(0, 90)], [stances.Stance(0, 90)]])
    for own in found:
        assert all(b.first - a.last >= steps.SWING for a, b in zip(own, own[1:], strict=False))
    flags = np.array([stances.standing(own, len(motion)) for own in found])
    assert flags.any(0).all(), "a foot stands in every frame"
    assert flags[:, :10].all() and flags[:, -10:].all()
    assert not flags[:, 30:60].all(0).all()


@pytest.mark.parametrize("fps", [24.0, 30.0, 60.0])
def test_a_glide_is_found_at_any_frame_rate(fps):
    motion = replace(gliding(speed=0.6 * 30 / fps, frames=round(3 * fps)), fps=fps)
    assert sum(map(len, steps.stepping(motion, [[], []]))) >= 3


def test_a_standing_foot_keeps_its_facing():
    frames = 30
    root, quats = standing(frames)
    quats[:, 0] = rotation.about_y(np.radians(np.linspace(0, 40, frames)))
    motion = Motion(root, quats, contacts=np.ones((frames, 5)))
    for locked in (lock_feet(motion, settings=replace(LABELLED, steps=False)), lock_feet(motion)):
        positions, _ = locked.forward_kinematics()
        along = positions[:, BALLS[0]] - positions[:, ANKLES[0]]
        facing = np.degrees(np.unwrap(np.arctan2(along[:, 0], along[:, 2])))
        assert np.ptp(facing) < 1.0


def test_a_foot_leaves_its_place_without_a_jump_of_speed():
    frames = 60
    root, quats = standing(frames)
    contacts = np.ones((frames, 5))
    contacts[25:36, FEET[0].column] = 0
    along = 0.4 / 30 * np.arange(frames)[:, None] * [0.0, 0.0, 1.0]
    motion = Motion(root + along, quats, contacts=contacts)
    locked = lock_feet(motion, settings=replace(LABELLED, steps=False))
    ball = locked.forward_kinematics()[0][:, FEET[0].ball, 2]
    change = np.abs(np.diff(np.diff(ball) * 30))
    assert change[23:27].max() < 0.75 * 0.4, "it would jump by 0.4 m/s"


def test_a_leg_does_not_snap_straight(monkeypatch):
    motion = gliding(speed=0.0, frames=40, bend=1.0)
    kick = np.clip((np.arange(40) - 20) / 3, 0, 1)[:, None] * [0.0, 0.0, 0.6]
    one = corrections.Correction(FEET[0], kick, np.zeros(40, bool))

    def snap():
        moved = corrections.apply(motion, [one], lambda tips: np.zeros(len(tips)), eased=True)
        angles = 2 * np.arccos(np.clip(np.abs(moved.rotations[:, KNEES[0], 0]), 0, 1))
        return np.abs(np.diff(angles, 2)).max()

    eased = snap()
    monkeypatch.setattr(corrections, "SNAP", 1.0)
    assert eased < 0.8 * snap()
