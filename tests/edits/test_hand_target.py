"""A hand is brought to a target, by arm and trunk, within their limits."""

from __future__ import annotations

import numpy as np
import pytest
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.body.joint_limits import limits
from samp_blender.samp_addon.edits.hand_target import hand_target, resting_frames
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.refine.hands.palm import HandContact, palm

AT = skeleton.INDEX
DOWN = np.array([0.0, -1.0, 0.0])
STANDING, SEATED = 0.95, 0.5
TRUNK = [AT[name] for name in ("spine1", "spine2", "spine3")]


def body(height=STANDING, count=60, yaw=0.0):
    """A body that stands, or sits with thighs level and shins upright, arms hanging down."""
    vectors = np.zeros((22, 3))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        vectors[AT[f"{side}_shoulder"], 2] = -1.2 * sign
        vectors[AT[f"{side}_elbow"], 1] = -0.35 * sign
        if height == SEATED:
            vectors[AT[f"{side}_hip"], 0], vectors[AT[f"{side}_knee"], 0] = -1.5, 1.5
    rotations = np.tile(rotation.from_axis_angle(vectors), (count, 1, 1))
    rotations[:, 0] = rotation.about_y(yaw)
    return Motion(np.tile([1.0, height, 2.0], (count, 1)), rotations)


def beside(motion, x, y, z):
    """A place x metres to the left of the pelvis, at height y, z metres in front."""
    flat = rotation.rotate(motion.rotations[0, 0], np.array([x, 0.0, z]))
    return motion.root[0] * [1, 0, 1] + flat + [0, y, 0]


def turned(before, after):
    """Degrees by which each joint of each frame turned."""
    turn = rotation.multiply(rotation.conjugate(before.rotations), after.rotations)
    return np.degrees(np.linalg.norm(rotation.to_axis_angle(turn), axis=-1))


@pytest.mark.parametrize("yaw", [0.0, 2.0])
@pytest.mark.parametrize(
    ("height", "side", "place", "facing", "leans"),
    [
        (STANDING, "left", (0.2, 1.1, 0.45), DOWN, False),  # a table in front
        (STANDING, "right", (-0.3, 1.7, 0.35), None, False),  # a shelf
        (STANDING, "right", (-0.2, 1.0, 0.78), None, True),  # across a table
        (SEATED, "left", (0.36, 0.66, 0.15), DOWN, False),  # an armrest
        (SEATED, "right", (-0.15, 0.75, 0.45), DOWN, False),  # a table
        (SEATED, "left", (-0.2, 0.8, 0.4), None, False),  # at the other side
    ],
)
def test_the_palm_is_on_the_target_within_the_joints_limits(height, side, place, facing, leans, yaw):
    motion = body(height, yaw=yaw)
    target = beside(motion, *place)
    made = hand_target(motion, side, target, 20, 50, 0.5, facing)
    middle, normal = palm(*made.motion.forward_kinematics(), motion.rest_joints, side)
    assert np.linalg.norm(middle[20:51] - target, axis=-1).max() < 0.01 and made.missed < 0.01
    angles = np.linalg.norm(rotation.to_axis_angle(made.motion.rotations), axis=-1)
    assert (angles[:, 1:] <= limits()[1:] + 1e-6).all()
    change = turned(motion, made.motion)
    assert (change[:, TRUNK].sum(1).max() > 30) == leans
    if facing is not None:
        assert (normal[20:51] @ facing).min() > np.cos(np.radians(20))
    moving = [*TRUNK, *(AT[f"{side}_{part}"] for part in ("collar", "shoulder", "elbow", "wrist"))]
    rest = [j for j in range(22) if j not in moving]
    assert np.array_equal(made.motion.rotations[:, rest], motion.rotations[:, rest])
    assert np.array_equal(made.motion.rotations[:5], motion.rotations[:5])
    assert np.abs(np.diff(change, axis=0)).max() < 20  # degrees from one frame to the next


@pytest.mark.parametrize(("place", "missed"), [((0.2, 1.2, 1.8), (0.7, 1.2)), ((0.3, 0.0, 0.5), (0.3, 0.7))])
def test_what_is_out_of_reach_is_missed_by_so_much(place, missed):
    motion = body()
    made = hand_target(motion, "left", beside(motion, *place), 30, 55, 0.8)
    assert missed[0] < made.missed < missed[1] and 30 <= made.frame <= 55
    angles = np.linalg.norm(rotation.to_axis_angle(made.motion.rotations), axis=-1)
    assert (angles[:, 1:] <= limits()[1:] + 1e-6).all()
    still = made.motion.rotations[30:56]
    assert np.abs(still - still[0]).max() < 0.01  # and the body does not shake


def test_a_target_that_moves_is_followed_frame_by_frame():
    motion = body(SEATED, 90)
    circle = np.linspace(0, 2 * np.pi, 90)
    target = beside(motion, 0.1, 0.85, 0.4) + 0.08 * np.stack(
        [np.cos(circle), np.sin(circle), 0 * circle], -1
    )
    made = hand_target(motion, "left", target)
    middle, _ = palm(*made.motion.forward_kinematics(), motion.rest_joints, "left")
    assert np.linalg.norm(middle - target, axis=-1).max() < 0.01
    assert np.abs(np.diff(turned(motion, made.motion), axis=0)).max() < 6


def test_without_a_range_the_hand_is_there_while_the_body_rests():
    motion = body(SEATED, 90)
    assert resting_frames(motion) == (0, 89)
    root = motion.root + np.linspace(0.4, 0, 90).clip(0.2)[:, None] * [0, 1, 0]
    sits = Motion(root, motion.rotations, interaction_start=20)
    first, last = resting_frames(sits)
    assert 40 < first < 60 and last == 89


def test_contacts_are_stored_and_cut():
    contact = HandContact(
        "left", np.arange(12.0).reshape(4, 3), np.array([0, 0.5, 1, 1.0]), np.tile(DOWN, (4, 1))
    )
    again = HandContact.of(contact.stored())
    for name in ("places", "weight", "facing"):
        assert np.array_equal(getattr(again, name), getattr(contact, name))
    longer = contact.between(-2, 5)
    assert longer.weight.tolist() == [0, 0, 0, 0.5, 1, 1, 0, 0]
    assert longer.places[2:6].tolist() == contact.places.tolist()
    assert contact.without(np.array([0, 0, 0, 1], bool)).weight.tolist() == [0, 0.5, 1, 0]


def test_an_empty_range_is_refused():
    with pytest.raises(ValueError, match="empty"):
        hand_target(body(count=10), "left", np.zeros(3), 8, 5)
