"""Postures of a body at rest, posed by hand: seated with the thighs forward, or lying."""

from __future__ import annotations

import numpy as np
import pytest
from samp_blender.models.motion_net import POSTURES as COUNT
from samp_blender.samp_addon import rotation
from samp_blender.samp_addon.evaluation import rest_posture
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.skeleton import INDEX
from samp_blender.samp_addon.vocabulary import POSTURE_NAMES, POSTURES


def arms(shoulder, elbow):
    """Return rotation vectors, degrees, of both arms for those of the left one."""
    mirrored = lambda vector: (vector[0], -vector[1], -vector[2])
    return {
        "left_shoulder": shoulder, "right_shoulder": mirrored(shoulder),
        "left_elbow": elbow, "right_elbow": mirrored(elbow),
    }  # fmt: skip


SEATED = arms((0, 0, -78), (0, 0, 0)) | {
    "left_hip": (-88, 0, 0), "right_hip": (-88, 0, 0), "left_knee": (85, 0, 0), "right_knee": (85, 0, 0),
}  # fmt: skip
HANDS = ("hands_on_lap", "hands_on_armrests", "hands_on_table")


def posed(degrees, whole=(0, 0, 0), yaw=0.0):
    """Return a motion of two frames; degrees: rotation vectors of joints. whole: of the pelvis."""
    quats = np.zeros((2, 22, 4))
    quats[..., 0] = 1
    for name, vector in degrees.items():
        quats[:, INDEX[name]] = rotation.from_axis_angle(np.radians(vector))
    turned = rotation.multiply(
        rotation.about_y(np.array([yaw])), rotation.from_axis_angle(np.radians(whole))[None]
    )
    quats[:, 0] = turned
    return Motion(np.tile([0.3, 0.5, -0.2], (2, 1)), quats)


@pytest.mark.parametrize("yaw", [0.0, 2.0])
@pytest.mark.parametrize(
    "joints, whole, yes, no",
    [
        (SEATED, (4, 0, 0), ["upright"], ["lean_back", "legs_crossed", "hands_on_table"]),
        (SEATED, (-14, 0, 0), ["lean_back"], ["upright"]),
        (SEATED, (35, 0, 0), [], ["upright", "lean_back"]),
        (SEATED | {"left_hip": (-80, 0, -40), "right_hip": (-80, 0, 40)}, (0, 0, 0), ["legs_crossed"], []),
    ],
)
def test_seated(joints, whole, yes, no, yaw):
    found = rest_posture.flags(posed(joints, whole, yaw), "sit")
    assert set(found) == set(POSTURES["sit"])
    assert all(found[name].all() for name in yes) and not any(found[name].any() for name in no)


@pytest.mark.parametrize(
    "shoulder, elbow, posture",
    [
        ((0, -35, -85), (0, -25, 0), ["hands_on_lap"]),
        ((0, -20, -75), (0, -40, 20), ["hands_on_armrests"]),
        ((0, -30, -75), (0, -70, 0), ["hands_on_table"]),
        ((0, 0, -78), (0, 0, 0), []),
    ],
)
def test_hands(shoulder, elbow, posture):
    found = rest_posture.flags(posed(SEATED | arms(shoulder, elbow)), "sit")
    assert [name for name in HANDS if found[name].all()] == posture


@pytest.mark.parametrize(
    "joints, whole, posture",
    [
        ({}, (-90, 0, 0), "on_back"),
        ({}, (-60, 0, 0), "half_sitting"),
        ({}, (0, 0, 90), "on_side"),
    ],
)
def test_lying(joints, whole, posture):
    found = rest_posture.flags(posed(joints, whole), "lie")
    assert {name for name, flags in found.items() if flags.all()} == {posture}


def test_shares_are_in_the_order_of_the_networks():
    assert len(POSTURE_NAMES) == COUNT
    shares = rest_posture.shares(posed(SEATED, (-14, 0, 0)), "sit", np.arange(2))
    assert shares[POSTURE_NAMES.index("lean_back")] == 1 and shares[6:].sum() == 0
    assert not rest_posture.shares(posed(SEATED), "walk", np.arange(2)).any()
