"""Seats behind a gap that a body passes only sideways, as in a theatre."""

from __future__ import annotations

import numpy as np
import pytest
from samp_blender.samp_addon.clock import Clock
from samp_blender.samp_addon.methods.method import Draw
from samp_blender.samp_addon.methods.samp.finishing.ground.narrow_way import keep_on
from samp_blender.samp_addon.methods.samp.planning import Planner
from samp_blender.samp_addon.methods.scene_view import SceneView
from samp_blender.samp_addon.methods.step import Step
from samp_blender.samp_addon.motion import Goal, Motion
from samp_blender.samp_addon.scene.geometry import SceneGeometry
from samp_blender.tests.support.layouts import box, moved

ROW = np.concatenate([box((-1.5, 0.38, -0.42), (1.5, 0.44, 0)), box((-1.5, 0.2, -0.52), (1.5, 1.0, -0.42))])
FLOOR = box((-4, -0.1, -4), (4, 0, 4))
GOAL = Goal(np.array([0.0, 0.62, -0.25]), np.array([0.0, 0.0, 1.0]), "sit")


def request(gap):
    """Return the request for a seat whose front is `gap` metres behind the back of another row."""
    others = moved(ROW, by=(0, 0, 0.52 + gap))
    scene = SceneGeometry.from_objects([("Floor", FLOOR), ("Row 1", others), ("Row 2", ROW)])
    view = SceneView(scene, ROW, ("Row 2",), start=(np.array([0.0, 0.0, -3.0]), 0.0))
    planner = Planner(Step(action="sit", target="Row 2"), view, lambda *_: [GOAL], view.navmesh)
    return planner.request(Draw(0, 0), Clock())


@pytest.mark.parametrize(("gap", "narrow"), [(0.38, True), (0.9, False)])
def test_a_narrow_gap_is_walked_through_and_remarked_on(gap, narrow):
    made = request(gap)
    assert ("narrower than 44 cm" in " ".join(made.remarks)) == narrow
    assert (made.free is not None) == narrow
    end = made.waypoints[-1]
    assert abs(end[0]) < 0.8 and 0 < end[2] < gap


def test_a_walking_pelvis_is_moved_out_of_the_other_row():
    made = request(0.38)
    frames = 60
    root = np.zeros((frames, 3)) + [0.0, 0.93, 0.1]
    root[:, 0] = np.linspace(-1.0, 1.0, frames)
    root[20:40, 2] = 0.45  # inside the back of row 1
    motion = Motion(root, np.tile([1.0, 0, 0, 0], (frames, 22, 1)), 30.0)
    moved_ = keep_on(motion, made.free, np.ones(frames))
    assert moved_.root[22:38, 2].max() < 0.38 - 0.09
    assert np.allclose(moved_.root[:3], root[:3], atol=2e-3)
    assert np.abs(np.diff(moved_.root[:, 2] - root[:, 2])).max() < 0.04
    seated = keep_on(motion, made.free, np.zeros(frames))
    assert np.array_equal(seated.root, root)


@pytest.mark.parametrize(("height", "kept"), [(2.5, True), (0.4, False)], ids=["a wall", "a low table"])
def test_a_body_sits_down_clear_of_a_wall_but_leans_over_a_low_table(height, kept):
    bench = box((-0.6, 0.38, -0.42), (0.6, 0.44, 0))
    other = box((-0.6, 0.0, 0.4), (0.6, height, 0.8))
    scene = SceneGeometry.from_objects([("Floor", FLOOR), ("Other", other), ("Bench", bench)])
    view = SceneView(scene, bench, ("Bench",), start=(np.array([-2.0, 0.0, 0.2]), 0.0))
    planner = Planner(Step(action="sit", target="Bench"), view, lambda *_: [GOAL], view.navmesh)
    made = planner.request(Draw(0, 0), Clock())
    pelvis = np.array([[0.0, 0.9, 0.35]])
    assert (made.free(pelvis)[0, 2] < 0.25) == kept
