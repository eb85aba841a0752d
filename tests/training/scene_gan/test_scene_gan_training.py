"""Scene GAN training: losses, going on after a stop, pretraining."""

from dataclasses import replace

import pytest
import scene_gan_data as tiny
import torch
from samp_blender.training.scene_gan import gpu, pretrain
from samp_blender.training.scene_gan.data import dataset
from samp_blender.training.scene_gan.learning import curves, losses, options
from samp_blender.training.scene_gan.learning.trainer import Trainer

SMALL = {"width": 32, "noise": 4, "pose_noise": 4, "scene": 16, "encoder_width": 8, "batch": 16, "rate": 2e-3}


@pytest.fixture(scope="module")
def data():
    return dataset.Dataset(tiny.arrays())


@pytest.fixture(autouse=True)
def one_thread():
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


def test_the_penalty_is_zero_at_its_target():
    steep = lambda slope: lambda x: slope * x[:, 0]
    real, made, share = torch.randn(4, 3), torch.randn(4, 3), torch.rand(4)
    assert float(losses.gradient_penalty(steep(losses.TARGET), real, made, share)) == pytest.approx(
        0, abs=1e-9
    )
    assert float(losses.gradient_penalty(steep(1.1), real, made, share)) == pytest.approx(1.0, rel=1e-4)


def test_inverse_huber_is_linear_then_quadratic():
    true, known = torch.zeros(1, 3), torch.tensor([[1.0, 1.0, 0.0]])
    made = torch.tensor([[0.1, 1.0, 50.0]])
    expected = (0.1 + (1 + 0.2**2) / 0.4) / 2
    assert float(losses.inverse_huber(made, true, known)) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("row", ["csgn", "all"])
def test_a_row_of_the_table_steps_and_goes_on(data, row, tmp_path):
    wanted = options.row(row, view="height", critic_steps=1, **SMALL | {"batch": 4})
    one, two = (
        Trainer(data, wanted),
        Trainer(data, options.row(row, view="height", seed=5, critic_steps=1, **SMALL)),
    )
    one.step()
    one.save(tmp_path / "state.pt")
    two.options = wanted
    two.resume(tmp_path / "state.pt")
    for each in (one, two):
        each.cache_features(tmp_path)
        each.step()
    assert len(list(tmp_path.glob("features_*.pt"))) == 1
    assert two.step_number == 2 and set(one.losses()) >= {f"{name}_distance" for name in wanted.critics}
    for name, value in one.networks.state_dict().items():
        torch.testing.assert_close(two.networks.state_dict()[name], value, msg=name)


def test_a_training_begins_with_the_parts_of_others(data, tmp_path):
    parts = {"trajectory": 1, "pose": 2}
    trained = {}
    for part, seed in parts.items():
        made = Trainer(
            data, replace(options.row("md", view="height", seed=seed, **SMALL), part=part, critics=(part,))
        )
        made.save(tmp_path / part)
        trained[part] = made
    joint = Trainer(data, options.row("md", view="height", seed=3, **SMALL))
    for part in parts:
        joint.begin(tmp_path / part, part)
    for part, made in trained.items():
        own = made.networks.state_dict()
        for name, value in joint.networks.state_dict().items():
            if name.startswith(f"{part}."):
                assert torch.equal(value, own[name]), name
        for name, value in made.critics[part].state_dict().items():
            assert torch.equal(joint.critics[part].state_dict()[name], value), name
    joint.step()


def test_pretraining_learns_the_depth(data, tmp_path):
    made = pretrain.Pretraining(data, options.row("all", **SMALL).settings, ("depth", "normals"))
    first = made.step(4, 2e-3)["depth"]
    for _ in range(12):
        last = made.step(4, 2e-3)["depth"]
    assert last < 0.7 * first
    error = made.depth_error(data)
    assert error["pictures"] == 2 and 0 <= error["delta_1_25"] <= 1
    made.save(tmp_path)
    again = pretrain.Pretraining(data, made.settings, made.tasks)
    again.resume(tmp_path)
    assert again.step_number == 13


def test_curves_are_kept_and_drawn(tmp_path):
    for step in (1, 2, 3):
        curves.note(tmp_path / "log.jsonl", step, 0.5 * step, {"a": 1 / step, "b": step})
    with (tmp_path / "log.jsonl").open("a") as file:
        file.write('{"step": 4, "a"')
    rows = curves.read(tmp_path / "log.jsonl")
    assert [row["step"] for row in rows] == [1, 2, 3]
    curves.draw(rows, tmp_path / "curves.png")
    assert (tmp_path / "curves.png").stat().st_size > 500


def test_an_archive_in_pieces(tmp_path, monkeypatch):
    monkeypatch.setattr(gpu, "MOST", 40_000)
    monkeypatch.setattr(gpu, "PIECES", 40)
    (tmp_path / "work" / "all").mkdir(parents=True)
    (tmp_path / "out").mkdir()
    (tmp_path / "work" / "all" / "a.safetensors").write_bytes(bytes(range(256)) * 400)
    (tmp_path / "work" / "all" / "state.pt").write_bytes(b"left out")
    (tmp_path / "work" / "rough_128").mkdir()
    (tmp_path / "work" / "rough_128" / "a.safetensors").write_bytes(bytes(300))
    parts = gpu.archive(tmp_path / "work", tmp_path / "out")
    assert len(parts) == 3 and all(part.stat().st_size <= 40_000 for part in parts)
    gpu.join(tmp_path / "out", tmp_path / "again")
    assert (tmp_path / "again" / "all" / "a.safetensors").read_bytes() == bytes(range(256)) * 400
    assert sorted(p.name for p in (tmp_path / "again").rglob("*.*")) == ["a.safetensors"]


def test_runs_begin_with_their_parts():
    sizes = {"width": "128", "draws": "4"}
    rough, way = gpu.parts_of(options.row("all"), sizes).items()
    assert rough[0] == "rough_128" and way[0] == "way_encoder_colour_64_128"
    assert rough[1][-2:] == way[1][-2:] == ["--width", "128"] and "--draws" in way[1]
    assert gpu.parts_of(options.row("csgn"), sizes) == {}


def test_runs_by_name():
    assert gpu.parse_run("csgn:width=256,seed=1") == ("csgn", {"width": "256", "seed": "1"})
    with pytest.raises(Exception, match="unknown row"):
        gpu.parse_run("other")


def test_the_nearest_draw_counts(data):
    batch = data.batch(torch.arange(3))
    true = batch.motions
    rows = torch.arange(3).repeat_interleave(2)
    moved = true.rows(rows)
    away = torch.tensor([[0.0, 0, 0], [0.3, 0, 0]]).repeat(3, 1)[:, None]
    made = replace(moved, root=moved.root + away)
    for part in ("trajectory", "all"):
        assert float(losses.nearest_of(made, true, 2, part)) == pytest.approx(0, abs=1e-6)
        assert float(losses.nearest_of(made, true.rows(rows), 1, part)) == pytest.approx(0.15, abs=1e-5)


@pytest.mark.parametrize(
    ("gain", "phase", "least", "most"), [(1, 0, 0, 0), (1, 1.5, 0, 0.25), (0, 0, 1, 1), (2, 0, 1, 1)]
)
def test_spectra_see_amplitudes_and_hardly_phases(gain, phase, least, most):
    """A sway every ten frames; errors relative to that of no sway. Phases count in the short windows only."""
    angle = 2 * torch.pi * torch.arange(64) / 10
    sway = lambda amplitude, shift: amplitude * torch.cos(angle + shift).expand(1, 3, 64)
    error = lambda made: float(losses.spectral_error(made, sway(0.3, 0.0)))
    assert least - 0.01 <= error(sway(0.3 * gain, phase)) / error(torch.zeros(1, 3, 64)) <= most + 0.01


def test_weights_that_are_kept_do_not_change(data, tmp_path):
    wanted = replace(
        options.row("all", view="height", draws=2, spectral=1.0, **SMALL), part="trajectory", critics=()
    )
    first = Trainer(data, wanted)
    for _ in range(2):
        first.step()
    first.save(tmp_path / "state.pt")
    later = Trainer(data, replace(wanted, kept=("trajectory.rough",), seed=1))
    later.begin(tmp_path / "state.pt", "trajectory")
    for _ in range(2):
        later.step()
    made = later.averaged().state_dict()
    same = {name for name, value in first.average.items() if torch.equal(made[name], value)}
    own = {name for name in made if name.startswith("trajectory.")}
    assert own & same == {name for name in own if name.startswith("trajectory.rough")} != own


@pytest.mark.parametrize("part", ["trajectory", "rough_pose"])
def test_draws_come_nearer_without_critics(data, part):
    wanted = replace(options.row("all", view="height", draws=2, **SMALL), part=part, critics=())
    made = Trainer(data, wanted)
    before = {name: value.clone() for name, value in made.networks.state_dict().items()}
    made.step()
    first = made.losses()["nearest"]
    for _ in range(25):
        made.step()
    made.losses()
    for _ in range(5):
        made.step()
    assert made.losses()["nearest"] < 0.8 * first
    after = made.networks.state_dict()
    changed = {name.split(".")[0] for name in before if not torch.equal(before[name], after[name])}
    assert changed == {part.removeprefix("rough_")}
    assert wanted.sees_scene == (part == "trajectory")


def test_steps_of_time_differ_for_a_constant_condition():
    """Without a code of the step, the middle of a window could not differ from its neighbours."""
    from samp_blender.models.scene_gan import generators

    sizes = generators.Sizes(scene=16, width=64, noise=4, pose_noise=4)
    inputs = generators._over_time(torch.zeros(2, 4, 6), torch.ones(2, 16))
    assert inputs.shape == (2, 26, 6) and not torch.equal(inputs[..., 2], inputs[..., 3])
    way = torch.arange(64.0).expand(2, 3, 64)
    steps = generators._steps_of(way)
    assert torch.equal(steps[0, :16, 1], torch.arange(16.0)) and torch.equal(steps[..., 0], steps[..., 1])
    assert sizes.channels() == (64, 32, 32, 32, 32)


def test_batches_can_have_more_bodies_that_travel(data):
    far = lambda batch: (batch.motions.root[:, -1] - batch.motions.root[:, 0])[:, [0, 2]].norm(dim=-1)
    draws = lambda: torch.Generator().manual_seed(0)
    every = far(data.batch(torch.arange(len(data))))
    assert set(data.moving.tolist()) == set(torch.nonzero(every >= 0.399)[:, 0].tolist())
    if len(data.moving):
        assert (far(data.sample(8, draws(), moving=0.5))[:4] >= 0.399).all()
    assert torch.equal(data.sample(8, draws(), moving=0.0).pairs, data.sample(8, draws()).pairs)


def test_turns_about_bones_are_centred_away(data):
    made = Trainer(data, replace(options.row("md", view="height", **SMALL), critics=()))
    bias = made.networks.pose.rough.last.bias
    with torch.no_grad():
        bias.view(22, 6, -1)[12, 0] -= 0.4  # the neck turns in all windows
    batch = data.batch(torch.arange(8))

    def error() -> float:
        with torch.no_grad():
            known = batch.motions.velocities
            six = made.networks.draw(
                made.scene(batch), batch.start, torch.Generator().manual_seed(0), known
            ).six
        return float((six - batch.motions.six)[:, 1:, 12].abs().mean())

    before = error()
    made.centre(4)
    assert error() < 0.5 * before
    assert torch.equal(made.average["pose.rough.last.bias"], bias)
