"""The trainings of the long-term method on a tiny corpus: packed and read back, every stage takes a step, resumes."""

import numpy as np
import pytest
import rooms
import torch
from samp_blender.models import weights
from samp_blender.models.long_term import gait, layout
from samp_blender.models.long_term.pose_prior import PosePrior
from samp_blender.samp_addon import rotation
from samp_blender.training.long_term import pack, side_by_side, train
from samp_blender.training.long_term.data import LongTermData, matrices, reflected
from samp_blender.training.long_term.evaluation import baselines, intervals, predicted
from samp_blender.training.long_term.stages import orientations, paper, sub_goal, windows
from samp_blender.training.rooms.corpus import store
from samp_blender.training.rooms.episodes.bank import LABELS
from samp_blender.training.rooms.layout.room import Room

FRAMES, SPEED = 150, 0.9


def walk(seed):
    """Return root (T, 3) and rotations (T, 22, 4) of a walker that swings its legs and turns a little."""
    time = np.arange(FRAMES) / 30
    phase = 2 * np.pi * time * SPEED / gait.STRIDE_LENGTH
    swing = 0.35 * np.sin(phase)
    rotations = np.zeros((FRAMES, 22, 4))
    rotations[..., 0] = 1
    for hip, knee, sign in ((1, 4, 1), (2, 5, -1)):
        bend = 0.8 * np.clip(sign * np.cos(phase), 0, 1)
        for joint, angle in ((hip, -sign * swing), (knee, bend)):
            rotations[:, joint] = np.stack([np.cos(angle / 2), np.sin(angle / 2), 0 * angle, 0 * angle], -1)
    yaw = 0.5 * seed + 0.2 * np.sin(time)
    rotations[:, 0] = np.stack([np.cos(yaw / 2), 0 * yaw, np.sin(yaw / 2), 0 * yaw], -1)
    root = np.zeros((FRAMES, 3))
    root[:, 0], root[:, 2] = np.cumsum(np.sin(yaw) * SPEED / 30), np.cumsum(np.cos(yaw) * SPEED / 30)
    root[:, 1] = 0.93
    return root, rotations


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    """A room of 8 m with a table, and two walkers in it."""
    cache = tmp_path_factory.mktemp("corpus")
    folder = store.room_folder(cache, 3)
    triangles = np.concatenate([rooms.box((-6, -0.1, -6), (6, 0, 6)), rooms.box((1, 0.6, 1), (2, 0.7, 2))])
    flat = np.zeros(len(triangles), np.int16)
    room = Room("office", (12.0, 12.0, 2.5), triangles, flat, flat, flat, ["p"], [], [], np.zeros((0, 4)))
    (folder / "layout").mkdir(parents=True)
    room.save(folder / "layout" / "room.npz")
    store.write_json(folder / "layout" / "notes.json", {})
    motion = [walk(seed) for seed in (1, 2)]
    contacts = np.zeros((2 * FRAMES, 5), np.uint8)
    contacts[:, 4] = 1
    store.write_stage(folder, "motion", {
        "bounds": np.array([0, FRAMES, 2 * FRAMES], np.int32), "shapes": np.full((2, 8), 0.1, np.float32),
        "root": np.concatenate([m[0] for m in motion]).astype(np.float32),
        "rotations": np.round(np.concatenate([m[1] for m in motion]) * store.QUATERNION).astype(np.int16),
        "labels": np.full(2 * FRAMES, 3, np.uint8), "contacts": contacts,
    })  # fmt: skip
    rng = np.random.default_rng(0)
    points = rng.uniform(-5, 5, (9000, 3)) * [1, 0, 1]
    normals = np.tile(np.array([0, 127, 0], np.int8), (len(points), 1))
    store.write_stage(folder, "cloud", {
        "points": points.astype(np.float32), "normals": normals, "classes": np.zeros(len(points), np.uint8),
    })  # fmt: skip
    entry = {"number": 3, "split": "train", "frames": 2 * FRAMES, "episodes": 2}
    store.write_json(cache / "manifest.json", {"rooms": [entry]})
    return cache


@pytest.fixture(scope="module")
def packed(corpus, tmp_path_factory):
    path = tmp_path_factory.mktemp("pack") / "long_term.bin"
    pack.main(["--corpus", str(corpus), "--output", str(path), "--windows", "12"])
    return path


@pytest.fixture(scope="module")
def data(packed):
    torch.manual_seed(0)
    return LongTermData.load(packed)


def test_a_pack_is_read_back(packed):
    raw = pack.read(packed)
    root, rotations = walk(1)
    np.testing.assert_allclose(raw["root"][:FRAMES], root, atol=pack.STEP)
    dot = np.abs((raw["rotations"][:FRAMES] * rotations).sum(-1))
    assert dot.min() > 1 - 1e-6
    assert raw["contacts"][:, 4].all() and not raw["contacts"][:, 3].any()
    for episode, first, length in raw["windows"]:
        assert length in pack.LENGTHS and first + length <= raw["lengths"][episode]
    assert raw["paths"].shape == (len(raw["windows"]), 16, 2)


@pytest.mark.parametrize("mirrored", [False, True])
def test_windows_begin_at_the_origin(data, mirrored):
    batch = data.window_batch(data.rows[61][:4], mirrored)
    assert batch.route.shape == (4, 61, 9) and batch.turns.shape == (4, 61, 21, 3, 3)
    assert batch.route[:, 0, [0, 2]].abs().max() < 1e-5
    yaw = layout.yaw_of(layout.matrix_from_six(batch.route[:, 0, 3:]))
    assert yaw.abs().max() < 1e-4
    # It walks ahead, along its path, and the phase goes on with the way.
    assert (batch.route[:, -1, 2] > 1.0).all()
    torch.testing.assert_close(batch.path[:, -1], batch.route[:, -1, [0, 2]], atol=0.01, rtol=0)
    wanted = 2 * torch.pi * 2.0 * SPEED / gait.STRIDE_LENGTH
    # The phase is read from the legs, exactly only where they pass each other: within a quarter of a cycle.
    assert (batch.total - wanted).abs().max() < torch.pi / 2
    cloud = data.cloud(batch, 64)
    near = torch.minimum(
        cloud[..., [0, 2]].norm(dim=-1), (cloud - batch.route[:, -1:, :3])[..., [0, 2]].norm(dim=-1)
    )
    assert near.max() < windows.RADIUS + 0.01


def test_mirrored_windows_are_mirror_images(data):
    rows = data.rows[61][:3]
    plain, mirrored = data.window_batch(rows), data.window_batch(rows, True)
    torch.testing.assert_close(mirrored.route[..., :3], reflected(plain.route[..., :3]), atol=1e-4, rtol=0)
    joints = [
        predicted.figures(data, predicted.truth(w), torch.zeros_like(w.betas))[0] for w in (plain, mirrored)
    ]
    swapped = reflected(joints[0][:, :, data._swap])
    torch.testing.assert_close(joints[1], swapped, atol=0.02, rtol=0)  # the body is nearly symmetric


def test_skin_behind_points_is_inside(data):
    cloud = torch.tensor([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]])
    normals = torch.tensor([[[0.0, 1.0, 0.0], [0.0, 1.0, 0.0]]])
    skin = torch.tensor([[[0.1, 0.05, 0.0], [0.9, -0.02, 0.0]]])
    distance, near = sub_goal.signed(skin, cloud, normals)
    torch.testing.assert_close(distance, torch.tensor([[0.05, -0.02]]))
    contact, collision = sub_goal.scene_terms(skin, skin + torch.tensor([0.0, 0.03, 0.0]), cloud, normals)
    assert float(collision) == pytest.approx(0.01) and 0 < float(contact) < 1


def test_orientations_of_the_actions(packed):
    """The second walker lies on its side on the floor instead, its head towards -X."""
    raw = pack.read(packed)
    side = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # of its columns: left, up, ahead
    lies = np.arange(len(raw["labels"])) >= FRAMES
    raw["labels"] = np.where(lies, LABELS.index("lie"), LABELS.index("walk"))
    raw["rotations"][lies, 0] = rotation.matrix_to_quaternion(side)
    raw["root"][lies, 1] = np.where(np.arange(FRAMES) % 2, 0.12, 0.16)
    data = LongTermData(raw)
    rows = torch.tensor([5, FRAMES + 5])
    torch.testing.assert_close(
        orientations.actions(data, rows), torch.tensor([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    )
    assert float(orientations.facing(data, rows)[1]) == pytest.approx(np.pi / 2)
    table = orientations.table(data)
    turned = layout.matrix_from_six(table[2, :, :6])
    torch.testing.assert_close(layout.lying_yaw_of(turned), torch.zeros(len(turned)), atol=1e-4, rtol=0)
    assert turned[:, 1, 0].abs().min() > 0.99 and len(torch.unique(turned[:, 1, 0].sign())) == 2
    rises = table[2, :, 6]
    assert float(rises.max() - rises.min()) == pytest.approx(0.04, abs=1e-4) and (rises.abs() < 1e-4).any()
    assert (table[1] == table[1, :1]).all() and float(table[1, 0, 0]) == 1  # without seated bodies
    prior = PosePrior()
    drawn = sub_goal.draw(data, prior, rows, mirror=False)
    asked, made = (layout.matrix_from_six(v) for v in (drawn.given[:, 3:], drawn.body[:, 3:9]))
    assert ((asked.transpose(1, 2) @ made).diagonal(dim1=1, dim2=2).sum(-1) > 2.6).all()


STAGES = ["prior", "points", "sub_goal", "route", "pose", *paper.NAMES]


@pytest.fixture(scope="module")
def work(packed, tmp_path_factory):
    """A folder with the weights of every stage after one step."""
    folder = tmp_path_factory.mktemp("work")
    common = ["--data", str(packed), "--work", str(folder), "--cpu", "--batch", "3", "--steps", "1"]
    train.main([*common, "--stages", *STAGES])
    return folder


def test_every_stage_leaves_weights(work):
    for stage in STAGES:
        tensors = weights.load_weights(f"long_term_{stage}", work)
        assert all(torch.isfinite(value).all() for value in tensors.values())
    assert not list(work.glob("*.checkpoint"))


def test_a_training_goes_on_from_its_checkpoint(data, tmp_path):
    first = train.Trainings(data, tmp_path, 4).learner("prior")
    first.step(0.0)
    train._keep(first, tmp_path / "long_term_prior.checkpoint", 7.0)
    lines = []
    second = train.Trainings(data, tmp_path, 4).learner("prior")
    train.run(second, tmp_path, 0.0, 3, lines.append)
    assert second.step_number == 3 and "resumes at step 1, 7 s" in lines[0]
    assert weights.weights_path("long_term_prior", tmp_path).exists()


def test_a_training_begins_with_the_weights_of_another(packed, work, tmp_path):
    train.main(["--data", str(packed), "--work", str(tmp_path), "--cpu", "--batch", "3", "--steps", "1",
                "--stages", "prior", "points", "--begin", str(work), "--rate", "1e-9"])  # fmt: skip
    for stage in ("prior", "points"):
        old, new = (weights.load_weights(f"long_term_{stage}", folder) for folder in (work, tmp_path))
        same = {k: torch.allclose(v.float(), new[k].float(), atol=2e-3) for k, v in old.items()}
        # The last layer of the prior's decoder begins anew.
        assert {k for k, v in same.items() if not v} <= {"decoder.4.weight", "decoder.4.bias"}, stage
        assert stage != "prior" or not same["decoder.4.weight"]


def test_codes_keep_their_meaning_when_the_prior_is_trained_on(data, work):
    learner = train.Trainings(data, work, 4).learner("prior")
    learner.begin_with(work)
    before = {k: v.clone() for k, v in learner.net.state_dict().items()}
    learner.step(0.0)
    after = learner.net.state_dict()
    assert all(torch.equal(after[k], v) == k.startswith("encoder") for k, v in before.items())


def test_the_archive_in_pieces(work, tmp_path, monkeypatch):
    monkeypatch.setattr(side_by_side, "MOST", 2**20)
    assert side_by_side.archive(work, tmp_path) > 2
    assert all(part.stat().st_size <= 2**20 for part in tmp_path.glob("weights.*"))
    names = side_by_side.join(tmp_path, tmp_path / "joined")
    assert len(names) == 2 * len(STAGES)
    assert weights.load_weights("long_term_pose", tmp_path / "joined")


def test_baselines(data):
    batch = data.window_batch(data.rows[61][:4])
    straight = baselines.interpolated(batch)
    for frame in (0, -1):
        torch.testing.assert_close(straight.route[:, frame], batch.route[:, frame], atol=1e-4, rtol=0)
        torch.testing.assert_close(straight.turns[:, frame], batch.turns[:, frame], atol=1e-4, rtol=0)
    # The bank holds the windows themselves: the nearest one is the same.
    nearest = baselines.NearestWindow(data)(batch)
    torch.testing.assert_close(nearest.route, batch.route, atol=1e-3, rtol=0)
    torch.testing.assert_close(nearest.turns, batch.turns, atol=1e-3, rtol=0)


def test_errors_of_the_captured_motion_are_none(data):
    batch = data.window_batch(data.rows[61][:4])
    found = predicted.errors(data, PosePrior(), batch, predicted.truth(batch))
    assert all(
        found[name].abs().max() < 1e-3 for name in ("translation", "orientation", "pose", "MPJPE", "MPVPE")
    )
    assert found["v2v_speed"].abs().max() < 1e-3
    assert found["v2v"].mean() == pytest.approx(100 * SPEED / 30, rel=0.3)
    moved = predicted.Predicted(batch.route + torch.tensor([0.1] + [0.0] * 8), batch.turns)
    found = predicted.errors(data, PosePrior(), batch, moved)
    torch.testing.assert_close(found["MPJPE"], torch.full((4,), 100.0), atol=0.01, rtol=0)
    torch.testing.assert_close(found["translation"], torch.full((4,), 10 / 3), atol=0.01, rtol=0)


def test_intervals_resample_rooms():
    rooms_of = np.repeat([0, 1], 50)
    low, high = intervals.mean(rooms_of.astype(float), rooms_of)[1:]
    assert (low, high) == (0.0, 1.0)
    assert intervals.mean(np.ones(100), rooms_of) == (1.0, 1.0, 1.0)


def test_matrices_of_quaternions():
    half = float(np.sqrt(0.5))
    turned = matrices(torch.tensor([half, 0.0, half, 0.0], dtype=torch.float32)) @ torch.tensor(
        [0.0, 0.0, 1.0]
    )
    torch.testing.assert_close(turned, torch.tensor([1.0, 0.0, 0.0]), atol=1e-6, rtol=0)
