"""Training of MotionNet: observations of rollouts, drift, the step without host access, checkpoints and files."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from samp_blender.models import state, weights
from samp_blender.models.motion_net import LATENT, OBJECT, POSTURES, MotionNet
from samp_blender.samp_addon import skeleton
from samp_blender.samp_addon.methods.samp.rollout.rollout import Rollout
from samp_blender.samp_addon.methods.samp.rollout.start import Start
from samp_blender.training.composition.sequence import Sequence, save
from samp_blender.training.samp.motion_net import merge
from samp_blender.training.samp.motion_net.learning import (
    compact,
    drift,
    frames,
    pieces,
    side_by_side,
    styles,
)
from samp_blender.training.samp.motion_net.learning.rollouts import LATEST, Draws, Rollouts
from samp_blender.training.samp.motion_net.learning.trainer import WINDOW, Trainer, window
from samp_blender.training.samp.motion_net.schedule import Schedule
from torch.utils._python_dispatch import TorchDispatchMode

FRAMES = 200
SEAT = np.array([0.0, 0.5, 6.0])

LAP = [1.0, 0.0, 1.0] + [0.0] * 6  # upright, hands on the lap


def glide(action):
    """Return a rest pose that moves 1 m/s along +Z with a sway of 3 cm; the goal is a seat 6 m ahead or a way-point."""
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
        placement=(0.4, 6.0, 0.0), weight=0.5, more=[(0, (1.0, 6.0, 0.0))] if action == 3 else [],
        posture=np.array(LAP if action == 3 else [0.0] * 9),
    )  # fmt: skip


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """Return the file of a mirrored set of two sequences with one piece of furniture."""
    sides = np.meshgrid(*[np.linspace(-0.3, 0.3, 8)] * 3, indexing="ij")
    grids = {
        "centres": np.stack(sides, -1).reshape(1, 512, 3).astype(np.float32),
        "occupancy": np.random.default_rng(0).uniform(size=(1, 512)).astype(np.float32),
    }
    place = tmp_path_factory.mktemp("training") / "motion.npz"
    save(place, [glide(3), glide(1)], grids, mirrored=True)
    return place


@pytest.fixture(scope="module")
def data(path):
    return frames.load(path, "cpu", window())


def trainer(data, truth=0.0, **options):
    torch.manual_seed(0)
    schedule = Schedule(1e-3, -2.0, -1.0, truth, 0.6, 0.5, hidden=32, **options)
    return Trainer(data, schedule, batch=4, seed=0)


def rollouts(data, first, drifts=False):
    """Return four rollouts at a frame that are fed with their own predictions."""
    torch.manual_seed(0)
    made = Rollouts(data, 4, WINDOW, drifts)
    made.progress.truth.fill_(0.0)
    made.at.fill_(first)
    made.clock.fill_(first)
    made.age.zero_()
    made.own.copy_(data.roots[made.at])
    return made


def path_of(states):
    return states[:, state.TRAJECTORY].reshape(-1, state.SAMPLES, 9)[:, state.NOW + 1 :, :4]


def test_only_the_future_is_planned(data):
    """The planned path does not sway with the steps."""
    told = data.states[100, state.TRAJECTORY].reshape(state.SAMPLES, 9).float().numpy()
    swaying = data.roots[100 + state.SAMPLE_OFFSETS, 0].numpy() - data.roots[100, 0].numpy()
    assert np.allclose(told[: state.NOW + 1, 0], swaying[: state.NOW + 1], atol=2e-3)
    assert np.abs(told[state.NOW + 1 :, 0] - swaying[state.NOW + 1 :]).max() > 0.01


def test_mirror_images(data):
    """Mirror images exchange left and right and have the furniture on the other side of the path."""
    assert len(data) == 4 * FRAMES and len(data.centres) == 2
    swap = torch.as_tensor(skeleton.mirror_joints())
    joints = data.states[[100, 100 + 2 * FRAMES], state.POSE].float().reshape(2, 22, 4, 3)[:, :, 0]
    assert torch.allclose(joints[1], joints[0, swap] * torch.tensor([-1.0, 1.0, 1.0]), atol=2e-3)
    at = torch.tensor([150, 150 + 2 * FRAMES])
    none = torch.zeros(2).long()
    features = data.object_features(at, data.roots[at], none, none.bool())
    seen = features[:, :OBJECT].reshape(2, 8, 8, 8, 4)
    assert seen[0].abs().sum() > 0
    assert torch.allclose(seen[1], seen[0].flip(0) * torch.tensor([-1.0, 1.0, 1.0, 1.0]), atol=1e-3)


# frames 60 and 150 of the sit are 4 m and 1 m before the seat; 260 is frame 60 of the walk
@pytest.mark.parametrize("frame, reach, planned", [(60, 1.4, True), (150, 1.4, False), (150, 0.4, True),
                                                   (260, 1.4, True), (260, 1e9, False)])  # fmt: skip
def test_the_path_is_planned_until_near_the_seat(data, frame, reach, planned):
    made = rollouts(data, frame)
    made.reach.fill_(reach)
    made.advance(data.targets[made.at].float() + 0.02, torch.ones(264), Draws.new(4, "cpu"))
    truth = data.states[made.at].float()
    assert (made.at - frame - 1).abs().max() <= 1 and (made.age == 1).all()
    assert not torch.allclose(made.x[:, state.POSE], truth[:, state.POSE], atol=1e-3), "the pose is predicted"
    assert torch.allclose(path_of(made.x), path_of(truth), atol=1e-5) == planned
    assert torch.allclose(made.x[:, state.GOAL], truth[:, state.GOAL], atol=1e-5)


@pytest.mark.parametrize("late", [0, -1, 1])
def test_a_late_or_early_rollout_is_aligned_with_its_frame(data, late):
    """The clip sways, so that its frames differ in their velocities."""
    made, at = rollouts(data, 262), torch.full((4,), 262)
    fed = data.states[at + late].float()
    assert (made._aligned(fed, at, at.float(), torch.ones(264)) == at + late).all()
    far = made._aligned(fed, at, at.float() - 2 * LATEST, torch.ones(264))
    assert (far == at - LATEST).all(), "never more than LATEST off the clock"


def test_drifted_rollouts_return_to_the_path(data):
    """With perfect predictions, rollouts off the captured path return to it, and observe the goal correctly."""
    made = rollouts(data, 262, drifts=True)
    aside = torch.tensor([[0.2, 0.0, 0.1], [-0.2, 0.1, 0.0], [0.0, 0.0, -0.3], [0.0, 0.0, 0.0]])
    made.own.copy_(drift.displace(data.roots[made.at], aside))
    for _ in range(50):
        made.advance(made.targets(), torch.ones(264), Draws.new(4, "cpu"))
    left = np.exp(-50 / state.FPS / drift.RETURN)
    assert torch.allclose(made.drift()[:, 2].abs(), left * aside[:, 2].abs(), atol=0.02)
    assert (made.drift()[:, 0].abs() < left * aside.norm(dim=-1) + 0.02).all(), "off the path"
    pose = made.x[:, state.POSE].reshape(4, 22, 4, 3)[:, :, 0]
    assert torch.allclose(
        pose, data.states[made.at, state.POSE].float().reshape(4, 22, 4, 3)[:, :, 0], atol=0.01
    )
    goal = made.x[:, state.GOAL].reshape(4, 13, 11)[:, state.NOW, :3]
    assert torch.allclose(goal[:, 0::2], state.flat_to_root(data.goal[made.at], made.own), atol=0.01)


def test_lost_rollouts_are_restarted(data):
    made = rollouts(data, 262, drifts=True)
    wrong = made.targets()
    wrong[0] = float("nan")
    wrong[1, state.TRAJECTORY.start + state.NOW * 9] += 2.0
    made.advance(wrong, torch.ones(264), Draws.new(4, "cpu"))
    assert made.age.tolist() == [0, 0, 1, 1] and made.x.isfinite().all()


def test_held_components_of_z_are_constant_and_others_are_drawn_every_step(data):
    made = trainer(data, held=8)
    mean, log_variance = torch.zeros(4, 64), torch.zeros(4, 64)
    first, again = (made._sample_z(mean, log_variance)[0] for _ in range(2))
    assert torch.equal(first[:, :8], again[:, :8]) and not torch.equal(first[:, 8:], again[:, 8:])
    assert torch.equal(first[:-1, :8], made.rollouts.styles()[:-1, :8])
    assert not first[-1, :8].any(), "the style of a tenth of the rollouts is unknown"
    centres, heights = torch.zeros(2, 512, 3), np.zeros((22, 4)) + [1.0, 0, 0, 0]
    starts = [Start.standing(0.93, heights, np.zeros(3))] * 2
    run = Rollout(
        made.net.eval(),
        starts,
        centres,
        torch.zeros(2, 512),
        [1, 2],
        torch.full((2, 1), 0.1),
        torch.tensor([3, 4]),
    )
    run.set_goals(torch.zeros(2, 11))
    assert run.held_z.shape == (2, 8)
    assert torch.equal(run.select(torch.tensor([1])).held_z, run.held_z[1:])


def test_held_components_are_drawn_from_styles_of_the_action(data):
    made = trainer(data, held=8)
    assert not made.net.style_codes.any()
    made.frames = replace(data, styles=torch.randn(len(data.styles), styles.SIZE))
    made.measure_styles()
    codes = made.net.style_codes
    for action, known in ((1, True), (2, False), (3, True)):  # the set has a walk and a sit
        assert bool(codes[action].any()) == known
    assert not codes[..., 8:].any()
    starts = [Start.standing(0.93, np.zeros((22, 4)) + [1.0, 0, 0, 0], np.zeros(3))] * 2
    shown = (torch.zeros(2, 512, 3), torch.zeros(2, 512), [1, 2])
    run = Rollout(made.net.eval(), starts, *shown, torch.full((2, 1), 0.1), torch.tensor([1, 3]))
    for held, action in zip(run.held_z, (1, 3), strict=True):
        assert torch.isclose(codes[action, :, :8], held).all(-1).any()


def test_a_style_is_drawn_among_those_of_the_posture(data):
    net = trainer(data, held=8).net.eval()
    net.style_codes[3] = torch.arange(128.0)[:, None]
    net.style_postures[3, :5, 1] = 1.0
    wanted = torch.zeros(40, 9)
    wanted[:, 1] = 0.9
    starts = [Start.standing(0.93, np.zeros((22, 4)) + [1.0, 0, 0, 0], np.zeros(3))] * 40
    shown = (torch.zeros(40, 512, 3), torch.zeros(40, 512), list(range(40)))
    run = Rollout(net, starts, *shown, torch.full((40, 1), 0.1), torch.full((40,), 3), wanted)
    assert set(run.held_z[:, 0].round().tolist()) == {0.0, 1.0, 2.0, 3.0, 4.0}


def test_styles_tell_people_apart_and_not_actions():
    """Twelve walks and twelve runs of three people, who hold an elbow at different heights."""
    lengths, person = np.full(24, 40), np.tile([0.0, 0.1, 0.2], 8)
    actions = np.repeat([1, 2], 12)
    parts = 0.001 * torch.randn(24, 40, state.SIZE)
    parts[:, :, 3] += torch.as_tensor(person, dtype=torch.float32)[:, None]
    parts[:, :, 5] += torch.as_tensor(actions, dtype=torch.float32)[:, None]
    weights = parts[..., state.TRAJECTORY].reshape(24, 40, state.SAMPLES, 9)
    for k, action in enumerate(actions):
        weights[k, :, state.NOW, 4 + action] = 1.0
    parts[..., state.TRAJECTORY] = weights.reshape(24, 40, -1)
    found = styles.measure(parts.flatten(0, 1), lengths, actions)
    assert found.shape == (24, styles.SIZE)
    first = found[:, 0].numpy()
    assert abs(np.corrcoef(first, person)[0, 1]) > 0.99
    assert abs(np.corrcoef(first, actions)[0, 1]) < 0.1
    assert not found[:, styles.SIZE // 2 :].any(), "no sequence rests"


def test_a_step_reads_no_value_on_the_host(data):
    """A step that can be captured as a graph on a GPU transfers no value to or from the host."""
    seen = []

    class Watch(TorchDispatchMode):
        def __torch_dispatch__(self, operation, types, args=(), kwargs=None):
            seen.append(str(operation))
            return operation(*args, **(kwargs or {}))

    made = trainer(data, held=8)
    made._advance()
    with Watch():
        made._advance()
    forbidden = ("lift_fresh", "_local_scalar_dense", "nonzero", "masked_select")
    assert len(seen) > 100 and not [name for name in seen if any(word in name for word in forbidden)]


def test_training_reduces_the_loss_and_resumes(data, tmp_path):
    through = trainer(data, 1.0, held=4)
    for _ in range(60):
        through.step(0.0)
    before = through.losses()["loss"]
    through.save(tmp_path / "checkpoint.pt")
    for _ in range(60):
        through.step(0.0)
    assert through.losses()["loss"] < 0.8 * before
    again = trainer(data, 0.5, held=4)
    again.resume(tmp_path / "checkpoint.pt")
    assert again.step_number == 60
    saved = torch.load(tmp_path / "checkpoint.pt", weights_only=True)["net"]
    assert all(torch.equal(value, saved[name]) for name, value in again.net.state_dict().items())


def test_a_network_without_the_object_is_blind_to_it(data):
    net = trainer(data, sees_object=False).net
    some, other = torch.rand(2, OBJECT + POSTURES), torch.zeros(2, OBJECT + POSTURES)
    seen = [net.normalised_object(values)[:, :OBJECT] for values in (some, other)]
    assert torch.allclose(*seen, atol=0.05)


def test_postures_of_rests_are_known_to_some_rollouts_on_the_way_to_them(data):
    """The sit is upright with hands on the lap; the walk has no posture."""
    at = torch.tensor([150, 150, 150 + FRAMES])
    none, shown = torch.zeros(3).long(), torch.tensor([True, False, True])
    features = data.object_features(at, data.roots[at], none, shown)[:, OBJECT:]
    assert features.tolist() == [LAP, [0.0] * 9, [0.0] * 9]
    rows, shares = data.posture_shares(32)
    assert rows[0].tolist() == LAP and shares.tolist() == [1.0] + [0.0] * 31
    made = rollouts(data, 150)
    made.shown.copy_(torch.tensor([True, False, True, False]))
    assert torch.equal(made.object_features()[:, OBJECT], torch.tensor([1.0, 0.0, 1.0, 0.0]))


def test_a_training_begins_with_weights_that_know_no_postures(data, tmp_path):
    earlier = MotionNet(32)
    for value in (*earlier.parameters(), earlier.object_mean):
        torch.nn.init.normal_(value, std=0.05)
    tensors = earlier.state_dict()
    decoder = {
        k: v for k, v in tensors.items() if k.startswith(("decoder", "input", "target", "object", "held"))
    }
    weights.save_weights("motion_net", decoder, tmp_path)
    weights.save_weights("encoder", {k: v for k, v in tensors.items() if k not in decoder}, tmp_path)
    begun = trainer(data)
    begun.begin_with(tmp_path)
    x, z, features = torch.randn(3, state.SIZE), torch.randn(3, LATENT), torch.rand(3, OBJECT + POSTURES)
    assert torch.allclose(begun.net.step(x, features, z), earlier.step(x, features[:, :OBJECT], z), atol=0.02)
    assert begun.net.posture_shares[0] == 1, "the shares of postures are those of the new data"


def test_the_compact_file_has_the_same_arrays(path):
    raw = dict(np.load(path))
    compact.write(raw, path.with_suffix(".bin"))
    back = compact.read(path.with_suffix(".bin"))
    assert set(back) == set(raw)
    for name, near in (("root", 2e-5), ("rotations", 0), ("piece_centres", 1e-5), ("piece_occupancy", 3e-3),
                       ("actions", 3e-3), ("goal", 0), ("lengths", 0), ("more_placements", 0)):  # fmt: skip
        assert np.abs(raw[name].astype(float) - back[name].astype(float)).max() <= near, name


def test_merging_kinds_of_two_sets(path):
    raw = dict(np.load(path))
    walk, sit = (merge.chosen(raw, raw["kinds"] == kind) for kind in ("walk", "sit"))
    both = merge.joined(walk, sit)
    assert both["kinds"].tolist() == ["walk", "sit"] and both["pieces"].tolist() == [-1, 1]
    assert np.array_equal(both["root"][FRAMES:], raw["root"][:FRAMES])
    with pytest.raises(ValueError, match="mirror"):
        merge.joined(walk, sit | {"mirrored": np.array(False)})
    around = sit | {"goal_grid": np.array(True)}
    assert merge.joined(walk, around)["goal_grid"], "a walk has no furniture"
    with pytest.raises(ValueError, match="drawn around goals"):
        merge.joined(around, sit)


def test_weights_are_split_and_assembled(data, tmp_path, monkeypatch):
    monkeypatch.setattr(pieces, "MOST", 2_000_000)
    name, options = side_by_side.parse_run("slim:hidden=32,batch=4,held=8,rate=1e-3,encoder=1,bfloat16=1")
    run = side_by_side.Run(name, options, data, graph=False, fuse=False)
    run.queue_steps(0.0)
    out, scratch = tmp_path / "out", tmp_path / "scratch"
    out.mkdir()
    scratch.mkdir()
    starts = {"start_heights": torch.ones(1), "start_rotations": torch.ones(1, 22, 4)}
    side_by_side.save([run], starts, out, scratch)
    assert len(list(out.glob("slim.*"))) > 1
    pieces.join(out, tmp_path / "joined")
    tensors = weights.load_weights("motion_net", tmp_path / "joined" / "slim")
    assert int(tensors["held"]) == 8 and not any(key.startswith("state_encoder") for key in tensors)
    first = "decoder.gate.0.weight"
    assert torch.allclose(tensors[first].float(), run.trainer.average[first], atol=1e-3)
    assert (tmp_path / "joined" / "slim" / "encoder.safetensors").exists()
