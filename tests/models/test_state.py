"""The layout of the state, tested with synthetic motion of known values."""

import numpy as np
import pytest
import torch
from samp_blender.models import state
from samp_blender.samp_addon import rotation
from samp_blender.samp_addon.skeleton import default_rest_joints
from samp_blender.training.samp.motion_net.learning.features import Encoder

FRAMES, SPEED, YAW = 120, 1.5, np.pi / 2


@pytest.fixture(scope="module")
def walk():
    """Return a rest pose that moves along +X, facing +X, at 1.5 m/s from (1, 0, 2); the seat is 6 m ahead."""
    root = np.zeros((FRAMES, 3))
    root[:, 0] = 1 + SPEED * np.arange(FRAMES) / state.FPS
    root[:, 1], root[:, 2] = 0.93, 2.0
    quats = np.zeros((FRAMES, 22, 4))
    quats[..., 0] = 1
    quats[:, 0] = rotation.about_y(YAW)
    actions = np.zeros((FRAMES, 5))
    actions[:, 1] = 1
    contacts = np.tile([0, 0, 0, 1, 0], (FRAMES, 1))
    goal = np.tile([7.0, 0.5, 3.0, 0.0, 0.0, 1.0], (FRAMES, 1))
    tensors = [
        torch.as_tensor(values, dtype=torch.float32) for values in (root, quats, actions, contacts, goal)
    ]
    encoder = Encoder(
        *tensors, torch.full((FRAMES,), 3), torch.zeros(FRAMES).long(), torch.full((FRAMES,), FRAMES - 1)
    )
    return *encoder.encode(torch.float32), encoder.roots


def test_slices_cover_the_state_once():
    covered = np.zeros(state.SIZE, int)
    for part in (
        state.POSE,
        state.FUTURE,
        state.TRAJECTORY,
        state.CONTACTS,
        state.GOAL_TRAJECTORY,
        state.GOAL,
    ):
        covered[part] += 1
    assert (covered == 1).all()


def test_pose_is_in_the_root_frame(walk):
    states, _, roots = walk
    joints = states[60, state.POSE].reshape(22, 4, 3)
    rest = default_rest_joints()[:22] + np.array([0.0, 0.93, 0.0])
    assert np.allclose(joints[:, 0], rest, atol=1e-4)
    assert np.allclose(joints[:, 1], [0, 0, 1], atol=1e-5) and np.allclose(joints[:, 2], [0, 1, 0], atol=1e-5)
    assert np.allclose(joints[:, 3], [0, 0, SPEED], atol=1e-3)
    assert np.allclose(roots[60], [1 + SPEED * 2, 2.0, YAW], atol=1e-4)


def test_trajectory_and_future(walk):
    states, _, _ = walk
    trajectory = states[60, state.TRAJECTORY].reshape(13, 9)
    assert np.allclose(trajectory[:, 1], SPEED * state.SAMPLE_OFFSETS / state.FPS, atol=1e-3)
    assert np.allclose(trajectory[:, [0, 2]], 0, atol=1e-4) and np.allclose(trajectory[:, 3], 1, atol=1e-5)
    assert np.allclose(trajectory[:, 4:], [0, 1, 0, 0, 0])
    future = states[60, state.FUTURE].reshape(22, 3)
    assert np.allclose(future[0], [0, 0.93, -SPEED], atol=1e-3)


def test_goal_slices(walk):
    states, _, _ = walk
    goals = states[60, state.GOAL].reshape(13, 11)
    # The root is at (4, 2) facing +X: the goal at (7, 0.5, 3) is 3 m ahead and 1 m to the right (-x of the root).
    assert np.allclose(goals[:, :3], [-1.0, 0.5, 3.0], atol=1e-3)
    assert np.allclose(goals[:, 3:6], [-1.0, 0.0, 0.0], atol=1e-5)
    assert np.allclose(goals[:, 6:], [0, 0, 0, 1, 0])
    relative = states[60, state.GOAL_TRAJECTORY].reshape(13, 4)
    assert np.allclose(relative[state.NOW], [-3.0, -1.0, 1.0, 0.0], atol=1e-3)


def test_contacts(walk):
    assert np.allclose(walk[0][60, state.CONTACTS], [0, 0, 0, 1, 0])


def test_target_is_the_next_frame_in_the_present_root(walk):
    states, targets, _ = walk
    again = state.reroot(targets[40:60])
    for part in (state.POSE, state.FUTURE, state.TRAJECTORY, state.CONTACTS):
        assert torch.allclose(again[:, part], states[41:61, part], atol=1e-4)
    moved = targets[40, state.TRAJECTORY].reshape(13, 9)[state.NOW]
    assert np.allclose(moved[:2], [0, SPEED / state.FPS], atol=1e-4)


def test_encoded_states_are_consistent(walk):
    states = walk[0][40:60]
    assert torch.allclose(state.consistent(states), states, atol=1e-4)


def test_reroot_of_a_turn():
    """A predicted root 1 m ahead, turned left by 90 degrees, becomes the new origin facing forward."""
    y = torch.zeros(1, state.SIZE)
    trajectory = y[:, state.TRAJECTORY].reshape(1, 13, 9).clone()
    trajectory[..., 1], trajectory[..., 2] = 1.0, 1.0
    trajectory[0, 12, :2] = torch.tensor([2.0, 1.0])
    y[:, state.TRAJECTORY] = trajectory.reshape(1, -1)
    pose = y[:, state.POSE].reshape(1, 22, 4, 3).clone()
    pose[0, 0, 0] = torch.tensor([0.0, 0.9, 1.0])
    pose[0, 0, 1] = torch.tensor([1.0, 0.0, 0.0])
    y[:, state.POSE] = pose.reshape(1, -1)
    out = state.reroot(y)
    assert torch.allclose(
        out[:, state.POSE].reshape(22, 4, 3)[0, :2], torch.tensor([[0, 0.9, 0], [0, 0, 1.0]]), atol=1e-6
    )
    new = out[:, state.TRAJECTORY].reshape(13, 9)
    assert torch.allclose(new[state.NOW, :4], torch.tensor([0.0, 0, 0, 1]), atol=1e-6)
    assert torch.allclose(new[12, :2], torch.tensor([0.0, 2.0]), atol=1e-6)


def test_the_object_fades_out_with_distance():
    centres, occupancy = torch.zeros(1, 512, 3), torch.ones(1, 512)
    near = state.interaction_features(centres, occupancy, torch.tensor([[0.0, 1.0, np.pi]]))
    assert near.reshape(512, 4)[:, 3].eq(1).all()
    assert torch.allclose(near.reshape(512, 4)[0, :3], torch.tensor([0.0, 0.0, 1.0]), atol=1e-5)
    assert state.interaction_features(centres, occupancy, torch.tensor([[0.0, 4.0, 0.0]])).eq(0).all()


def test_object_features_fade_as_the_shipped_weights_know_them():
    """The distance is rounded as for contiguous rows, bit for bit: takes of the shipped weights depend on it."""
    root = torch.randn(500, 3, generator=torch.Generator().manual_seed(0)) * torch.tensor([2.0, 2.0, 3.0])
    centres, occupancy = torch.zeros(500, 512, 3), torch.ones(500, 512)
    found = state.interaction_features(centres, occupancy, root).reshape(500, 512, 4)[:, 0, 3]
    distance = state.to_root(centres, root).mean(1)[:, [0, 2]].norm(dim=-1)
    assert torch.equal(found, ((3.0 - distance) / 0.5).clamp(0.0, 1.0))
    assert ((found > 0) & (found < 1)).any()
