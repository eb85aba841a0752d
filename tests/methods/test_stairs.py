"""Walks over stairs with the real networks: soles on treads, toes out of risers, a pelvis that rises evenly."""

from __future__ import annotations

import numpy as np
import pytest
from layouts import box, floor, stairs
from samp_blender.samp_addon.methods.method import Draw
from samp_blender.samp_addon.methods.samp.method import Samp
from samp_blender.samp_addon.methods.samp.unfolding import STEP, Unfolded
from samp_blender.samp_addon.methods.scene_view import SceneView
from samp_blender.samp_addon.methods.step import Step
from samp_blender.samp_addon.refine.feet.foot import FEET, sole_points, toe_tips
from samp_blender.samp_addon.scene import flights
from samp_blender.samp_addon.scene.geometry import SceneGeometry
from samp_blender.samp_addon.vocabulary import CONTACTS

GROUNDS = {
    "up": (5, 0.17, 0.29),
    "down": (5, 0.17, 0.29),
    "steep up": (4, 0.21, 0.25),
    "flat down": (8, 0.13, 0.34),
}


def scene(steps, rise, run):
    top, end = steps * rise, (steps - 1) * run
    return np.concatenate(
        [floor(8, 6, by=(0, -3)), stairs(steps, rise, run), box((-4, top - 0.1, end), (4, top, end + 4))]
    )


def ground(points, steps, rise, run):
    """Return the heights under points (T, 3)."""
    return np.clip(np.floor(points[:, 2] / run) + 1, 0, steps) * rise


def walked(name, action="walk", target=None):
    steps, rise, run = GROUNDS[name]
    triangles = scene(steps, rise, run)
    low, high = np.array([0.2, 0.0, -2.0]), np.array([-0.2, steps * rise, steps * run + 1.8])
    start, end = (high, low) if "down" in name else (low, high)
    geometry = SceneGeometry(triangles, np.zeros(len(triangles), int), ("stairs",))
    view = SceneView(geometry, start=(start, np.pi if "down" in name else 0.0), destination=(end, None))
    (take,), _ = Samp().generate(Step(action="walk", to=tuple(end)), view, [Draw(1, 1)], lambda *_: None)
    return take, end


@pytest.mark.parametrize("name", GROUNDS)
def test_a_walk_over_stairs(name):
    steps, rise, run = GROUNDS[name]
    take, end = walked(name)
    motion = take.motion
    assert np.linalg.norm((motion.root[-1] - end)[[0, 2]]) < 0.1
    positions, globals_ = motion.forward_kinematics()
    stood = set()
    for foot in FEET:
        soles = (
            *sole_points(positions, globals_, motion.rest_joints, foot.side),
            toe_tips(positions, globals_, motion.rest_joints, foot.side),
        )
        # A point in the face of a riser is not deep in the tread above: 5 mm beside it are looked at as well.
        beside = [np.array([0.0, 0.0, away]) for away in (-0.005, 0.0, 0.005)]
        floors = [
            np.min([ground(sole + away, steps, rise, run) for away in beside], axis=0) for sole in soles
        ]
        deep = np.max([low - sole[:, 1] for low, sole in zip(floors, soles, strict=True)], axis=0)
        assert deep.max() < 0.02
        standing = motion.contacts[:, CONTACTS.index(f"{foot.side}_foot")] > 0.5
        lowest = np.min([sole[:, 1] for sole in soles], axis=0) - ground(soles[1], steps, rise, run)
        assert np.percentile(np.abs(lowest[standing]), 90) < 0.02
        stood |= set(np.round(ground(soles[1][standing], steps, rise, run) / rise).astype(int))
    assert stood == set(range(steps + 1)), "each tread carries a foot"
    sign = -1 if "down" in name else 1
    climbing = slice(
        *np.searchsorted(sign * motion.root[:, 2], np.sort(sign * np.array([0.0, (steps - 1) * run])))
    )
    rises = sign * np.diff(motion.root[climbing, 1])
    assert rises.min() > -0.004, "no saw-tooth"
    assert (np.abs(np.diff(motion.root[:, 1], 2)) * motion.fps**2).max() < 15


def test_an_unfolded_path_folds_back():
    steps, rise, run = GROUNDS["up"]
    way = np.array([[0, 0, -2.0], [0, 0, -0.1], [0, steps * rise, steps * run], [0, steps * rise, 3.5]])
    found = flights.find(way, scene(steps, rise, run))
    unfolded = Unfolded.of(way, found)
    longer = (steps - 1) * (STEP - run)
    np.testing.assert_allclose(unfolded.points[-1], way[-1])
    np.testing.assert_allclose(unfolded.points[0], way[0] - [0, 0, longer], atol=0.05)
    assert (np.diff(unfolded.points[:, 2]) > -1e-9).all()
    gone = np.linspace(0, 5.4 + longer, 60)
    line = np.stack([0 * gone, 0 * gone, unfolded.points[0, 2] + gone], -1)
    folded = np.array([unfolded.folded(point, at) for point, at in zip(line, gone, strict=True)])
    assert (np.diff(folded[:, 2]) > 0).all(), "in order, without a jump"
    assert np.diff(folded[:, 2]).max() < 0.12
    np.testing.assert_allclose(folded[[0, -1], 2], [-2.0, 3.4], atol=0.05)
