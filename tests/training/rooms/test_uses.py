"""Uses: a captured sit on a chair ends with its pelvis over the seat, and placed uses keep clear of other things."""

import numpy as np
import pytest
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.training.furniture import shapes
from samp_blender.training.mocap.clip_files import Clip
from samp_blender.training.rooms.classes import Part
from samp_blender.training.rooms.layout.stock import Item
from samp_blender.training.rooms.uses.composed import Composed

SEAT, STANDING, SEATED = 0.45, 0.93, 0.63  # metres


def sitting_clip():
    """A body that stands in front of a seat at z = 0, sits down on it, holds, and rises."""
    down = np.concatenate(
        [np.zeros(30), np.linspace(0, 1, 20), np.ones(60), np.linspace(1, 0, 20), np.zeros(20)]
    )
    down = down * down * (3 - 2 * down)
    count = len(down)
    root = np.zeros((count, 3))
    root[:, 1], root[:, 2] = STANDING + (SEATED - STANDING) * down, 0.30 * (1 - down)
    quats = np.zeros((count, 22, 4))
    quats[..., 0] = 1
    for joint, degrees in (("left_hip", -85), ("right_hip", -85), ("left_knee", 85), ("right_knee", 85)):
        bend = np.radians(degrees) * down[:, None] * np.array([1.0, 0.0, 0.0])
        quats[:, skeleton.INDEX[joint]] = rotation.from_axis_angle(bend)
    labels = np.array(["idle"] * 30 + ["sit_down"] * 20 + ["sit"] * 60 + ["stand_up"] * 20 + ["idle"] * 20)
    return Clip("sitting", root, quats, labels, np.ones((count, 2)), np.zeros(count, bool))


@pytest.fixture(scope="module")
def stool():
    top = shapes.box((-0.2, SEAT - 0.04, -0.2), (0.2, SEAT, 0.2), 4)
    leg = shapes.box((-0.03, 0.0, -0.03), (0.03, SEAT - 0.04, 0.03))
    return Item("stool", "stool", [Part("chair", shapes.join([top, leg]))])


def test_a_captured_sit_is_carried_to_a_seat(tmp_path, stool):
    composed = Composed([sitting_clip()], tmp_path)
    uses = composed.of(stool)
    assert uses and all(use.action == "sit" for use in uses)
    low, high = stool.box
    for use in uses:
        pelvis = np.median(use.root[use.seated : use.seat_end + 1], axis=0)
        assert (pelvis[[0, 2]] > low[[0, 2]]).all() and (pelvis[[0, 2]] < high[[0, 2]]).all()
        assert 0.1 < pelvis[1] - SEAT < 0.26
        assert len(use.root) == len(use.labels) == len(use.source) == len(use.feet)
    entering = [use for use in uses if use.down >= 0]
    assert entering and all(use.down < use.seated < use.seat_end < use.up_end for use in entering)
    again = composed.of(stool)
    np.testing.assert_array_equal(again[0].root, uses[0].root)
