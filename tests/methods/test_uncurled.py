"""A body that rests on a bed with its chest in the air is laid down, and counts as lying once it has rested so."""

import numpy as np
import pytest
from samp_blender.samp_addon import rotation
from samp_blender.samp_addon.methods.samp.finishing import uncurled
from samp_blender.samp_addon.methods.samp.request import Request
from samp_blender.samp_addon.methods.samp.rollout.tracking import (
    FPS,
    STAYS_RAISED,
    Observation,
    RolloutProgress,
)
from samp_blender.samp_addon.methods.samp.route import Route
from samp_blender.samp_addon.motion import Goal, Motion

WAY, REST = 40, 90


def lies(bend, roll=0.0):
    """Return a body that comes to rest on its back, with each joint of the spine bent forward by an angle, degrees."""
    quats = np.zeros((WAY + REST, 22, 4))
    quats[..., 0] = 1
    about = lambda axis, degrees: rotation.from_axis_angle(np.radians(degrees) * np.array(axis, float))
    quats[:, 0] = rotation.multiply(about([0, 0, 1], roll), about([1, 0, 0], -90))
    quats[:, uncurled.SPINE] = about([1, 0, 0], bend)
    along = np.concatenate([np.linspace(-0.5, 0, WAY), np.zeros(REST)])
    return Motion(np.stack([along, np.full(WAY + REST, 0.6), np.zeros_like(along)], -1), quats)


def upright(motion):
    turns = motion.forward_kinematics()[1][:, uncurled.CHEST]
    return 1 - 2 * (turns[:, 1] ** 2 + turns[:, 3] ** 2)


def test_a_raised_chest_is_laid_down_once_the_body_rests():
    before = lies(18.0)
    after = uncurled.uncurled(before)
    assert upright(before)[-1] > uncurled.RAISED and upright(after)[-1] <= uncurled.FLAT
    assert np.allclose(after.rotations[: WAY - 13], before.rotations[: WAY - 13], atol=1e-3)
    rest = [k for k in range(22) if k not in uncurled.SPINE]
    assert np.array_equal(after.rotations[:, rest], before.rotations[:, rest])
    assert np.array_equal(after.root, before.root)
    assert np.abs(np.diff(upright(after))).max() < 0.04, "without a jump"


@pytest.mark.parametrize("motion", [lies(4.0), lies(18.0, roll=90.0)], ids=["flat", "curled on a side"])
def test_bodies_that_lie_stay_as_they_are(motion):
    assert uncurled.uncurled(motion) is motion


@pytest.mark.parametrize(("upright", "seconds"), [(0.2, 0.0), (0.68, STAYS_RAISED)])
def test_when_a_rest_counts_as_lying(upright, seconds):
    goal = Goal(np.array([0.0, 0.6, 1.0]), np.array([0.0, 0, 1.0]), "lie")
    beside = np.array([0.0, 0.0, 0.3])
    route = Route(np.zeros(3), beside[None], goal, "lie")
    tracked = RolloutProgress([Request(np.zeros(3), 0.0, "lie", goal)], [route])
    number = lambda value: np.array([value])
    place = goal.position[None]
    seen = Observation(place[:, [0, 2]], place, number(0.01), number(0.0), np.eye(5)[4:], number(upright))
    for frame in range(3 * FPS):
        tracked.update(seen, frame)
        if tracked.held[0]:
            break
    assert frame / FPS == pytest.approx(seconds, abs=0.07)
