"""MotionNet's training: what its rollouts see of the future, and a training that can be stopped and gone on with."""

import numpy as np
import pytest
import torch
from samp_blender.models import state
from samp_blender.training.composition.sequence import Sequence, save
from samp_blender.training.samp.motion_net import dataset, train

FRAMES = 200
SEAT = np.array([0.0, 0.5, 6.0])


def glide(action):
    """A rest pose that glides 1 m/s along +Z with a sway of 3 cm; the goal is a seat 6 m ahead, or a way-point."""
    root = np.zeros((FRAMES, 3))
    root[:, 2] = np.arange(FRAMES) / state.FPS
    root[:, 0] = 0.03 * np.sin(2 * np.pi * 0.9 * np.arange(FRAMES) / state.FPS)
    root[:, 1] = 0.93
    quats = np.zeros((FRAMES, 22, 4))
    quats[..., 0] = 1
    goal = np.tile([*SEAT, 0.0, 0.0, 1.0], (FRAMES, 1))
    return Sequence(
        "sit" if action == 3 else "walk", root, quats, np.array(["walk"] * FRAMES), np.zeros((FRAMES, 2)),
        np.zeros(FRAMES, bool), goal, np.full(FRAMES, action), piece=0 if action == 3 else -1,
    )  # fmt: skip


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    folder = tmp_path_factory.mktemp("training")
    rng = np.random.default_rng(0)
    grids = {
        "centres": rng.normal(size=(1, 512, 3)).astype(np.float32),
        "occupancy": rng.uniform(size=(1, 512)).astype(np.float32),
    }
    save(folder / "motion.npz", [glide(3), glide(1)], grids)
    return dataset.load(folder / "motion.npz", folder / "features")


def trainer(data, truth=0.0):
    schedule = train.Schedule(600, 1e-3, -2.0, -1.0, truth, 0.6, 0.5)
    return train.Trainer(data, schedule, batch=4, seed=0)


def path_of(states):
    return states[:, state.TRAJECTORY].reshape(-1, state.SAMPLES, 9)[:, state.NOW + 1 :, :4]


def test_the_planned_path_does_not_sway_with_the_steps():
    clip = glide(1)
    roots = torch.as_tensor(np.column_stack([clip.root[:, 0], clip.root[:, 2], np.zeros(FRAMES)]))
    planned = dataset.smooth_path(roots)[40:-40]
    assert planned[:, 0].abs().max() < 0.3 * roots[:, 0].abs().max()
    assert torch.allclose(planned[:, 1], roots[40:-40, 1], atol=1e-3)


def test_only_the_future_is_planned(data):
    told = data.states[100, state.TRAJECTORY].reshape(state.SAMPLES, 9).astype(np.float32)
    swaying = data.roots[100 + state.SAMPLE_OFFSETS, 0].numpy() - data.roots[100, 0].numpy()
    assert np.allclose(told[: state.NOW + 1, 0], swaying[: state.NOW + 1], atol=2e-3)
    assert np.abs(told[state.NOW + 1 :, 0] - swaying[state.NOW + 1 :]).max() > 0.01


# frames 60 and 150 of the sit are 4 m and 1 m before the seat; 260 is frame 60 of the walk
@pytest.mark.parametrize("frame, reach, planned", [(60, 1.4, True), (150, 1.4, False), (150, 0.4, True),
                                                   (260, 1.4, True), (260, 1e9, False)])  # fmt: skip
def test_the_path_is_planned_until_near_the_seat(data, frame, reach, planned):
    trainer_ = trainer(data)
    frames = np.full(4, frame)
    truth = torch.as_tensor(data.states[frames].astype(np.float32))
    predicted = truth + 0.05
    x, at = trainer_._next_input(predicted, frames, frames, torch.ones(4, 1), torch.full((4, 1), reach))
    truth = torch.as_tensor(data.states[at].astype(np.float32))
    assert np.abs(at - frames).max() <= 1
    assert not torch.allclose(x[:, state.POSE], truth[:, state.POSE], atol=1e-3), (
        "with P = 0 the pose is its own"
    )
    assert torch.allclose(path_of(x), path_of(truth)) == planned
    assert torch.allclose(x[:, state.GOAL], truth[:, state.GOAL])


@pytest.mark.parametrize("late", [0, -1, 1])
def test_a_rollout_that_is_late_or_early_is_told_the_frame_it_is_at(data, late):
    """The clip sways, so that its frames can be told apart by their velocities."""
    frames = np.full(4, 262)
    fed = torch.as_tensor(data.states[frames + late].astype(np.float32))
    assert (trainer(data)._aligned(fed, frames, frames) == frames + late).all()
    far = trainer(data)._aligned(fed, frames, frames - 2 * train.LATEST)
    assert (far == frames - train.LATEST).all(), "never farther off the clock than that"


def test_training_goes_on_where_it_stopped(data, tmp_path):
    through = trainer(data, 1.0)
    losses = [through.rollout()["loss"]]
    through.save(tmp_path / "checkpoint.pt")
    losses.append(through.rollout()["loss"])
    assert losses[1] < 0.7 * losses[0], "sixty steps on two sequences must teach something"
    again = trainer(data, 0.5)
    again.resume(tmp_path / "checkpoint.pt")
    assert again.step_number == train.WINDOW
    assert all(
        torch.equal(a, b) for a, b in zip(again.net.state_dict().values(),
                                          _saved(tmp_path / "checkpoint.pt"), strict=True)
    )  # fmt: skip
    assert np.array_equal(again.draw_windows(), _windows_after(data, tmp_path / "checkpoint.pt"))


def _saved(path):
    return torch.load(path, weights_only=True)["net"].values()


def _windows_after(data, path):
    other = trainer(data, 0.5)
    other.resume(path)
    return other.draw_windows()


def test_a_network_that_shall_not_see_the_object_sees_nothing_of_it(data):
    schedule = train.Schedule(600, 1e-3, -2.0, -1.0, 0.0, 0.6, 0.5, sees_object=False)
    net = train.Trainer(data, schedule, batch=4, seed=0).net
    some, other = torch.rand(2, 2048), torch.zeros(2, 2048)
    assert torch.allclose(net.normalised_object(some), net.normalised_object(other), atol=0.05)
