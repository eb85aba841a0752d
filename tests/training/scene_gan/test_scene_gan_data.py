"""The data set of Scene GAN: motion in the view frame, mirrored, moved pictures; one file and back."""

import importlib.util

import numpy as np
import pytest
import scene_gan_data as tiny
import shapes
import torch
from samp_blender.models.scene_gan import projection
from samp_blender.samp_addon import skeleton
from samp_blender.training.rooms.corpus import store
from samp_blender.training.rooms.episodes.bank import LABELS
from samp_blender.training.rooms.layout.room import Room
from samp_blender.training.rooms.pictures import camera as cameras
from samp_blender.training.scene_gan.data import dataset, make, packing, room_windows, units


@pytest.fixture(scope="module")
def data():
    return dataset.Dataset(tiny.arrays())


def test_motion_is_in_the_view_frame(data):
    """Window 0 glides along the room's X: to the left of a camera that looks along Z, away from one along X."""
    batch = data.batch(torch.tensor([0, 1]))
    moved = batch.motions.root[:, -1] - batch.motions.root[:, 0]
    torch.testing.assert_close(moved[0], torch.tensor([tiny.WAY, 0.0, 0.0]), atol=2e-3, rtol=0)
    torch.testing.assert_close(moved[1], torch.tensor([0.0, 0.0, tiny.WAY]), atol=2e-3, rtol=0)
    torch.testing.assert_close(batch.start.height, torch.full((2,), 0.93), atol=1e-3, rtol=0)
    again = projection.Motions.of(batch.start, batch.motions.velocities, batch.motions.six[:, 1:])
    torch.testing.assert_close(again.root, batch.motions.root, atol=1e-5, rtol=0)
    torch.testing.assert_close(again.positions, batch.motions.positions, atol=1e-5, rtol=0)


def test_the_start_is_in_the_middle_of_the_picture(data):
    batch = data.batch(torch.arange(len(data)))
    places = projection.project(batch.start.root[:, None], batch.start)[:, 0]
    middle = torch.tensor([0.5, projection.ASPECT / 2])
    assert (places - middle).abs().max() <= 0.5 / tiny.WIDTH + 1e-5


def test_mirrored_windows_are_mirror_images(data):
    pairs = torch.arange(6)
    plain, mirrored = data.batch(pairs), data.batch(pairs, torch.ones(6, dtype=torch.bool))
    sign = torch.tensor([-1.0, 1.0, 1.0])
    torch.testing.assert_close(mirrored.motions.root, plain.motions.root * sign)
    swapped = list(dataset._MIRRORED)
    joints = plain.motions.positions[:, :, swapped] * sign
    torch.testing.assert_close(mirrored.motions.positions, joints, atol=1e-4, rtol=0)
    flat = projection.project(plain.motions.joints, plain.start)
    turned = projection.project(mirrored.motions.joints, mirrored.start)[:, :, swapped]
    torch.testing.assert_close(turned[..., 0], 1 - flat[..., 0], atol=1e-4, rtol=0)
    one, other = data.pictures("colour", plain), data.pictures("colour", mirrored)
    assert (one.flip(2) == other).all() and one.float().std() > 5
    torch.testing.assert_close(data.height_maps(mirrored), data.height_maps(plain).flip(2))


def test_views_and_targets(data):
    batch = data.batch(torch.arange(4))
    assert data.views("colour", batch).shape == (4, 3, tiny.HEIGHT, tiny.WIDTH)
    assert data.views("geometry", batch).shape == (4, 4, tiny.HEIGHT, tiny.WIDTH)
    assert data.views("height", batch).shape == (4, 2, 48, 48)
    assert data.standing(3).shape == (3, 22, 6)


def test_packed_and_back(tmp_path):
    arrays = tiny.arrays()
    packing.pack(arrays, tmp_path / "a.bin")
    again = packing.unpack(tmp_path / "a.bin", threads=2)
    assert set(again) == set(arrays)
    assert np.abs(again["root"].astype(int) - arrays["root"]).max() <= 2
    assert np.abs(again["rotations"].astype(int) - arrays["rotations"]).max() <= 24
    assert np.abs(again["colour"].astype(int) - arrays["colour"]).max() <= 2
    np.testing.assert_allclose(again["depth"], arrays["depth"], rtol=0.003)
    np.testing.assert_array_equal(again["pairs"], arrays["pairs"])
    (tmp_path / "b.bin").write_bytes(b"other")
    with pytest.raises(ValueError, match="not a packed data set"):
        packing.unpack(tmp_path / "b.bin")


def test_a_share_of_the_pictures():
    made = packing.thinned(tiny.arrays(), 0.5, np.random.default_rng(0))
    assert len(made["colour"]) == 1 and len(made["pairs"]) == tiny.WINDOWS == len(made["root"])
    assert made["pairs"][:, 0].max() == 0
    dataset.Dataset(made).batch(torch.arange(3))


def test_bodies_in_view_of_a_camera():
    camera = cameras.looking(np.array([0.0, 1.5, -3.0]), np.array([0.0, 1.0, 1.0]), 1.2)
    depth = np.full((36, 64), 5000, np.uint16)
    depth[:, 40:] = 1000  # a pillar on the right
    rest = np.array(skeleton.default_rest_joints()[:22]) + [0.0, 0.93, 0.0]
    places = np.array(
        [[0.0, 0, 1], [-1.0, 0, 1], [0, 0, 8], [5.0, 0, 1]]
    )  # free, hidden, behind the wall, outside
    found = room_windows.in_view(rest + places[:, None], camera, depth)
    assert found.tolist() == [True, False, False, False]


def test_the_label_of_standing_is_the_corpus_one():
    assert LABELS[units.IDLE] == "idle"


@pytest.mark.skipif(importlib.util.find_spec("embreex") is None, reason="pictures need the package embreex")
def test_a_room_of_a_corpus(tmp_path):
    """A glide through an empty room of 4 x 5 m becomes pictures, windows and pairs that see each other."""
    folder = store.room_folder(tmp_path / "corpus", 0)
    corners = shapes.box([-2, -0.1, -2.5], [2, 0, 2.5]), shapes.box([-2, 0, 2.4], [2, 2.5, 2.5])
    triangles = np.concatenate(corners)
    count = np.zeros(len(triangles), np.int16)
    classes = np.repeat(np.uint8([0, 1]), 12)
    size, nothing = (4.0, 5.0, 2.5), np.zeros((0, 4))
    room = Room("test", size, triangles, classes, count - 1, count, ["floor"], [], [], nothing)
    (folder / "layout").mkdir(parents=True)
    room.save(folder / "layout" / "room.npz")
    frames = 200
    quats = np.zeros((frames, 22, 4), np.int16)
    quats[..., 0] = store.QUATERNION
    root = np.stack([np.zeros(frames), np.full(frames, 0.93), np.linspace(-1, 1, frames)], -1).astype(
        np.float32
    )
    store.write_stage(folder, "motion", {
        "bounds": np.array([0, frames], np.int32), "shapes": np.zeros((1, 8), np.float32), "root": root,
        "rotations": quats, "labels": np.ones(frames, np.uint8), "contacts": np.zeros((frames, 5), np.uint8),
    })  # fmt: skip
    store.write_stage(folder, "cloud", {"points": triangles.reshape(-1, 3).astype(np.float32)})
    arguments = [
        "--corpus",
        str(tmp_path / "corpus"),
        "--output",
        str(tmp_path / "data"),
        "--pictures",
        "3",
        "--pairs",
        "4",
    ]
    assert make.main(arguments) == 0 and make.main(arguments) == 0
    data = dataset.load(tmp_path / "data" / "train")
    assert len(data.maps["colour"]) == 3 and len(data) > 3
    batch = data.batch(torch.arange(len(data)))
    assert batch.start.root[:, 2].min() > 1.0 and (data.pictures("depth", batch) > 0).float().mean() > 0.2


def test_some_pairs_are_kept_with_different_windows(data):
    before = data.small["pairs"]
    try:
        windows = len(before[:, 1].unique())
        data.keep(windows)
        kept = data.small["pairs"]
        assert len(kept) == windows == len(kept[:, 1].unique())
        rows = {tuple(row) for row in before.tolist()}
        assert all(tuple(row) in rows for row in kept.tolist())
    finally:
        data.small["pairs"] = before
