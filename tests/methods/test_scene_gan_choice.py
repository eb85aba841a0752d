"""Which draws of Scene GAN are followed, and for how long: free floor, furniture, other bodies, liveliness."""

import numpy as np
import pytest
import scene_gan_room
import torch
from samp_blender.samp_addon.body import balls, human
from samp_blender.samp_addon.body.balls import Track
from samp_blender.samp_addon.methods.scene_gan import improvisation, liveliness
from samp_blender.samp_addon.methods.scene_gan.judging import Judge
from samp_blender.samp_addon.motion import Motion
from scene_gan_room import STANDING


@pytest.fixture(scope="module")
def ground():
    return scene_gan_room.ground(scene_gan_room.room())


def upright(way, frames=65):
    """A window (T, 3), (T, 22, 4) of a body in the rest pose, arms to its sides, along a way of two places."""
    share = np.linspace(0, 1, frames)[:, None]
    flat = np.array(way[0]) * (1 - share) + np.array(way[1]) * share
    root = np.stack([flat[:, 0], np.full(frames, STANDING), flat[:, 1]], -1)
    return root, np.tile([1.0, 0, 0, 0], (frames, 22, 1))


def other(way, frames=65):
    """A body that stands in the rest pose, or goes along a way, over time."""
    made = balls.of_body(human.load())
    return Track(made.at(Motion(*upright(way, frames))), made.radii, 30.0)


@pytest.mark.parametrize(
    "way, others, low, high",
    [
        ([[2, -2], [-2, -2]], [], 64, 64),  # along the floor
        ([[0, -2.5], [0, 0]], [], 36, 56),  # up to the box, which begins at -0.5
        ([[1.09, -2], [1.09, 2]], [], 12, 32),  # beside the box, a hip in it
        ([[0, -2], [0, -4]], [], 24, 48),  # off the floor, which ends at -3
        ([[2, -2], [-2, -2]], [other([[-1.0, -2], [-1.0, -2]])], 16, 40),  # up to a body that stands there
        ([[2, -2], [2, -2]], [other([[-2, -2], [2, -2]])], 24, 48),  # another body comes
        ([[2, -2], [2, -2]], [other([[-2, 2], [2, 2]])], 64, 64),  # another body passes at a distance
        ([[2, -2], [0, -2]], [other([[1.6, -2], [-2, -2]])], 64, 64),  # another body goes away
    ],
)
def test_how_far_a_window_can_be_followed(ground, way, others, low, high):
    verdict = Judge(ground, others).of(*upright(way), 0.0, 0)
    assert low <= verdict.frames <= high


def test_a_window_begins_in_the_frame_of_the_others_in_which_it_is_given(ground):
    gone = other([[-2, -2], [2, -2]])  # at x = 0 in frame 32
    still = upright([[0, -2], [0, -2]])
    assert Judge(ground, [gone]).of(*still, 0.0, 0).frames < 40
    assert Judge(ground, [gone]).of(*still, 0.0, 60).frames == 64


def test_no_take_begins_where_another_body_stands(ground):
    places = np.array([[2.0, 0.0, -2.0], [0.0, 0.0, -2.0]])
    assert Judge(ground, [other([[2, -2], [2, -2]])]).meets(places).tolist() == [True, False]


@pytest.mark.parametrize(
    "speed, share, far",
    [(0.0, 0.5, 0.16), (0.0, 0.9, 1.15), (0.1, 0.1, 0.02), (2.0, 0.75, 1.69), (None, 0.5, 0.62)],
)
def test_how_far_bodies_go(speed, share, far):
    assert liveliness.wanted(speed, share) == pytest.approx(far, abs=0.01)


def standing(feet, head=1.5):
    """Return the joints (T, 22, 3) of a body with its feet at (T, 2, 3), and its head at a height."""
    joints = np.zeros((len(feet), 22, 3))
    joints[:, liveliness.BALLS] = feet
    joints[:, [liveliness.PELVIS, liveliness.HEAD_JOINT], 1] = 0.9, head
    return joints


def test_draws_that_step_are_more_like_captured_ones():
    """Of three windows that go a metre, one slides on both feet; the last one goes half a metre."""
    time = np.linspace(0, 1, 65)
    ahead = np.array([0.0, 0.0, 1.0])
    roots = np.stack([time[:, None] * ahead, time[:, None] * ahead, 0.5 * time[:, None] * ahead])
    first, second = np.clip(2 * time, 0, 1), np.clip(2 * time - 1, 0, 1)
    steps = np.stack([first, second], 1)[..., None] * ahead
    slides = np.stack([time, time], 1)[..., None] * ahead
    found = liveliness.unlike(np.stack([standing(f) for f in (steps, slides, 0.5 * steps)]), roots, 1.0)
    np.testing.assert_allclose(found, [0.0, 1.0 - liveliness.SLIDES, 0.5], atol=0.02)


@pytest.mark.parametrize(
    "head, pelvis, cost", [(1.5, 0.9, 0.0), (1.31, 0.85, 0.1 * liveliness.STOOPS), (1.0, 0.5, 0.0)]
)
def test_bodies_that_stoop_are_less_like_captured_ones(head, pelvis, cost):
    """A body that sits has a low head, too, and does not stoop."""
    joints = standing(np.zeros((65, 2, 3)), head)
    joints[:, liveliness.PELVIS, 1] = pelvis
    found = liveliness.unlike(joints[None], np.zeros((1, 65, 3)), 0.0)
    np.testing.assert_allclose(found, [cost], atol=1e-9)


def test_successive_seeds_begin_with_different_ways():
    """One of them hardly moves, one walks."""
    some = improvisation.Improviser(None, None, Judge(None), None)
    ways = [some._far(np.zeros((2, 3)), 0, None, seed) for seed in range(4)]
    assert min(ways) < 0.1 and max(ways) > 1.2 and min(abs(np.diff(sorted(ways)))) > 0.1
    walking = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.04]])  # of a step after another one: it goes on
    random = torch.Generator().manual_seed(0)
    assert some._far(walking, 0, random, 0) > 0.3


def test_a_pose_that_goes_on_has_no_jolt():
    root = np.array([[0.0, 0.95, 0.0], [0.0, 0.95, 0.02]])
    turns = np.zeros((2, 22, 4))
    turns[..., 0] = 1
    after = np.array([[0.0, 0.95, 0.04], [0.0, 0.95, 0.01]])
    np.testing.assert_allclose(improvisation.jolt(root, turns, after, turns), [0.0, 0.03], atol=1e-9)
