"""Feet on uneven ground."""

from __future__ import annotations

from dataclasses import replace

import bodies
import numpy as np
import pytest
from samp_blender.samp_addon.methods.samp.finishing.ground import terrain
from samp_blender.samp_addon.refine.feet.foot import FEET, sole_points
from samp_blender.samp_addon.vocabulary import CONTACTS


def planes(slope: float, across: float):
    """Return the heights of a plane that rises by ``slope`` along z and ``across`` along x."""
    return lambda points: slope * points[:, 2] + across * points[:, 0]


def shifted(seconds: float, travel: float):
    """Return a body that stands on a flat floor and is carried along z, with both feet in contact."""
    motion = bodies.standing(seconds)
    contacts = np.zeros((len(motion), len(CONTACTS)))
    contacts[:, [foot.column for foot in FEET]] = 1.0
    away = np.linspace(0.0, travel, len(motion))[:, None] * [0.0, 0.0, 1.0]
    return replace(motion, root=motion.root + away, contacts=contacts)


@pytest.mark.parametrize(
    ("slope", "across"),
    [(0.2, 0.0), (-0.3, 0.0), (0.0, 0.25), (0.3, 0.15)],
    ids=["up", "down", "side", "both"],
)
def test_soles_lie_on_a_slope(slope, across):
    motion, ground = shifted(2.0, 1.0), planes(slope, across)
    heights = ground(motion.root)
    flat = replace(motion, root=motion.root + heights[:, None] * [0.0, 1.0, 0.0])
    followed = terrain.follow(flat, heights, ground)
    off = lambda motion: max(
        np.abs(sole[10:-10, 1] - ground(sole[10:-10])).max()
        for foot in FEET
        for sole in sole_points(*motion.forward_kinematics(), motion.rest_joints, foot.side)
    )
    assert off(flat) > 0.02
    assert off(followed) < 0.012


@pytest.mark.parametrize("missing", [False, True])
def test_even_ground_and_no_ground_change_nothing(missing):
    motion = shifted(1.0, 1.0)
    ground = None if missing else planes(0.001, 0.0)
    assert terrain.follow(motion, ground(motion.root) if ground else motion.root[:, 1] * 0, ground) is motion


def test_holes_in_the_ground_are_bridged():
    motion = shifted(2.0, 2.0)
    slope = planes(0.2, 0.0)
    holed = lambda points: np.where(np.abs(points[:, 2] - 1.0) < 0.2, np.nan, slope(points))
    flat = replace(motion, root=motion.root + slope(motion.root)[:, None] * [0.0, 1.0, 0.0])
    whole, bridged = (terrain.follow(flat, slope(motion.root), ground) for ground in (slope, holed))
    joints = [motion.forward_kinematics()[0] for motion in (whole, bridged)]
    assert np.abs(joints[0] - joints[1]).max() < 0.03
