"""Hands on a table: laid down in the hold where a top is in reach, and taken away before standing up."""

from dataclasses import replace

import numpy as np
import pytest
from samp_blender.samp_addon import skeleton
from samp_blender.training.furniture import shapes
from samp_blender.training.rooms.classes import CLASS
from samp_blender.training.rooms.layout.room import Room
from samp_blender.training.rooms.uses import tables
from samp_blender.training.rooms.uses import use as uses

from .test_uses import sitting_clip

HEIGHT = 0.74


def sit():
    clip = sitting_clip()
    frames = (30, 50, 109, 129)
    return uses.in_frame(clip, (0.0, 0.0, 0.0), "sit", 0, frames, None)


def room(edge, height=HEIGHT):
    """A table whose near edge is so far ahead of the seat."""
    top = shapes.box((-0.5, height - 0.03, edge), (0.5, height, edge + 0.7), 8)
    count = len(top)
    return Room("dining", (6.0, 6.0, 2.5), top, np.full(count, CLASS["table"], np.uint8), np.zeros(count, np.int16),
                np.zeros(count, np.int16), ["table/0"], ["table"], ["table"], np.zeros((1, 4)))  # fmt: skip


@pytest.mark.parametrize("edge", [0.25, 0.38, 0.46])
def test_hands_lie_on_the_table_in_the_hold(edge):
    use = sit()
    made = tables.with_hands_on(
        use, use.root, use.rotations, tables.Tops.of(room(edge)), np.random.default_rng(0)
    )
    assert made is not None
    laid, rotations = made
    joints, _ = skeleton.forward_kinematics(use.root, rotations, skeleton.default_rest_joints())
    middle = (use.seated + use.seat_end) // 2
    for side in ("left", "right"):
        wrist = joints[:, skeleton.INDEX[f"{side}_wrist"]]
        assert abs(wrist[middle, 1] - HEIGHT - tables.WRIST_OVER) < 0.04
        assert wrist[middle, 2] > edge
    np.testing.assert_allclose(rotations[0], use.rotations[0], atol=1e-6)
    assert laid.hands[middle].min() == 1 and laid.hands[0].max() == 0 and laid.hands[-1].max() == 0


@pytest.mark.parametrize("edge, height", [(0.9, HEIGHT), (0.3, 0.45), (0.3, 1.1)])
def test_tables_out_of_reach_are_left_alone(edge, height):
    use = sit()
    tops = tables.Tops.of(room(edge, height))
    assert tables.with_hands_on(use, use.root, use.rotations, tops, np.random.default_rng(0)) is None
    lying = replace(use, action="lie")
    near = tables.Tops.of(room(0.3))
    assert tables.with_hands_on(lying, use.root, use.rotations, near, np.random.default_rng(0)) is None


def test_no_hands_lie_between_two_tops_of_different_heights():
    """The 95th percentile of 47 low and 3 high samples is a height at which there is none."""
    heights = np.array([0.05] * 47 + [0.25] * 3)
    points = np.column_stack([np.linspace(-0.2, 0.2, 50), heights, np.full(50, 0.4)])
    assert tables.Tops(points).places(np.zeros(3), 0.0, 0.15) is None
