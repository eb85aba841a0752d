"""Fingers that close around a thing until they touch it."""

from __future__ import annotations

import numpy as np
import pytest
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.body import human
from samp_blender.samp_addon.edits.grasping import SKIN, grasp
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.refine.hands.palm import HandContact, palm

FINGERS = ("index", "middle", "pinky", "ring", "thumb")


def cylinder(centre, along, radius, half=0.1, sides=24):
    """Triangles of a rod around a line."""
    along = along / np.linalg.norm(along)
    side = np.cross(along, [0.3, 0.5, 0.8])
    side /= np.linalg.norm(side)
    angles = np.linspace(0, 2 * np.pi, sides + 1)
    ring = radius * (np.cos(angles)[:, None] * side + np.sin(angles)[:, None] * np.cross(along, side))
    low, high = centre + ring - half * along, centre + ring + half * along
    return np.concatenate(
        [np.stack([low[:-1], low[1:], high[1:]], 1), np.stack([low[:-1], high[1:], high[:-1]], 1)]
    )


def reached(side, radius):
    """A body in the T-pose with a rod of a radius against its palm, across the fingers."""
    motion = Motion(np.tile([0.0, 1.0, 0.0], (9, 1)), np.tile([1.0, 0, 0, 0], (9, 22, 1)))
    middle, facing = palm(*motion.forward_kinematics(), motion.rest_joints, side)
    out = np.array([1.0 if side == "left" else -1.0, 0.0, 0.0])
    rod = cylinder(middle[0] + radius * facing[0] + 0.03 * out, np.array([0.0, 0.0, 1.0]), radius)
    weight = np.array([0, 0, 0.5, 1, 1, 1, 0.5, 0, 0])
    return motion, HandContact(side, middle, weight), rod


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("radius", [0.02, 0.03, 0.045])
def test_four_fingers_close_around_a_rod_and_stop_at_its_surface(side, radius):
    motion, contact, rod = reached(side, radius)
    made, touching = grasp(motion, contact, rod, 4)
    assert touching >= 4
    body = human.load()
    names = [f"{side}_{finger}{k}" for finger in FINGERS[:4] for k in (2, 3)]
    own = np.isin(body.weight_joints[:, 0], [skeleton.INDEX[name] for name in names])
    skin = human.skin(body, made)[4][own].astype(float)
    centre, along = rod.reshape(-1, 3).mean(0), np.array([0.0, 0.0, 1.0])
    away = np.linalg.norm(np.cross(skin - centre, along), axis=-1) - radius
    assert -0.008 < away.min() < SKIN


def test_smaller_things_are_held_by_fingers_that_bend_more():
    bends = []
    for radius in (0.02, 0.045):
        made, _ = grasp(*reached("right", radius)[:2], reached("right", radius)[2], 4)
        index = skeleton.INDEX["right_middle1"]
        bends.append(
            np.linalg.norm(rotation.to_axis_angle(made.rotations[4, index : index + 3]), axis=-1).sum()
        )
    assert bends[0] > bends[1] + 0.1


def test_frames_without_contact_and_all_else_stay_and_nothing_is_grasped_in_the_air():
    motion, contact, rod = reached("right", 0.03)
    made, _ = grasp(motion, contact, rod, 4)
    hand = np.arange(skeleton.INDEX["right_index1"], len(skeleton.JOINTS))
    free, touching = grasp(motion, contact, rod + [0, 3.0, 0], 4)
    assert touching == 0
    np.testing.assert_allclose(made.rotations[[0, 1, 8]], free.rotations[[0, 1, 8]], atol=1e-12)
    others = np.setdiff1d(np.arange(len(skeleton.JOINTS)), hand)
    np.testing.assert_allclose(made.rotations[:, others], free.rotations[:, others], atol=1e-12)
    assert np.abs(made.rotations[4, hand] - free.rotations[4, hand]).max() > 0.1
    assert np.array_equal(made.root, motion.root)
