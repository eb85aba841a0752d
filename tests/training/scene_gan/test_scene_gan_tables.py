"""Measures of the paper's tables: Motion FID, cylinders against the depth map's points, behaviour, spread over time."""

import numpy as np
import pytest
import scene_gan_data as tiny
import torch
from samp_blender.models.scene_gan import kinematics
from samp_blender.models.scene_gan.projection import Motions
from samp_blender.samp_addon.body import human
from samp_blender.samp_addon.methods.scene_gan import liveliness
from samp_blender.samp_addon.motion import Motion
from samp_blender.samp_addon.scene.camera_view import CameraView
from samp_blender.training.scene_gan.data import dataset
from samp_blender.training.scene_gan.tables import erd, finished_numbers, make, measures, ways


@pytest.fixture(scope="module")
def batch():
    data = dataset.Dataset(tiny.arrays())
    return data.batch(torch.arange(len(data)))


def moved(motions, **changes):
    return Motions(**(vars(motions) | changes))


def test_features_do_not_depend_on_the_camera(batch):
    """Two cameras see the same window at right angles."""
    seen = erd.frames(batch.motions)
    assert seen.shape == (2 * tiny.WINDOWS, 64, erd.NUMBERS)
    torch.testing.assert_close(seen[0::2], seen[1::2], atol=2e-3, rtol=0)


def test_fid_is_small_for_the_same_motion_and_grows(batch):
    torch.manual_seed(0)
    networks = {16: erd.Erd(8).eval()}
    real = erd.frames(batch.motions)
    noisy = real + 0.2 * torch.randn_like(real)
    same, other = (measures.motion_fid(networks, real, made) for made in (real, noisy))
    assert set(same) == {"short", "mid", "long", "mean"}
    assert same["mean"] < 1e-9
    assert other["mean"] > 1e-5


@pytest.mark.parametrize("radius, inside", [(0.03, 1), (0.06, 2)])
def test_points_inside_the_cylinders(radius, inside):
    joints = torch.zeros(1, 22, 3)
    joints[:, 4] = torch.tensor([0.0, 1.0, 0.0])  # a bone from the hip upwards
    for joint, parent in enumerate(kinematics.PARENTS):
        if parent >= 4 or joint in (7, 10):
            joints[:, joint] = joints[:, parent]
    points = torch.tensor([[0.02, 0.5, 0.0], [0.05, 0.5, 0.0], [0.2, 0.5, 0.0], [1e3, 1e3, 1e3]])
    assert measures.points_inside(joints, points, radius).tolist() == [inside]


def test_shares_of_behaviour(batch):
    sink = torch.linspace(0, -0.5, 65)[:, None] * torch.tensor([0.0, 1.0, 0.0])
    still = batch.motions.root[:, :1].expand(-1, 65, -1)
    walks = measures.behaviour(batch.motions, batch.start)
    assert (
        walks["walks"] == 1
        and walks["sits_down"] == 0
        and walks["way_m"] == pytest.approx(tiny.WAY, abs=0.01)
    )
    assert measures.behaviour(moved(batch.motions, root=still), batch.start)["stays"] == 1
    assert measures.behaviour(moved(batch.motions, root=still + sink), batch.start)["sits_down"] == 1


def test_spread_between_the_same_ends():
    share = torch.linspace(0, 1, 65)
    bow = torch.sin(np.pi * share)
    ways = torch.stack([torch.stack([a * bow, 0 * share, 2 * share], -1) for a in (-0.3, 0.0, 0.3)])
    found = measures.spread(ways)
    assert found[0] < 1e-5 and found[-1] < 1e-5 and found[32] == pytest.approx(0.3, abs=0.01)


def test_a_table(tmp_path):
    data = dataset.Dataset(tiny.arrays())
    rows = np.arange(len(data))
    real = erd.frames(data.batch(torch.as_tensor(rows)).motions)
    networks = {16: erd.Erd(4).eval()}
    row = make.evaluate(data, lambda batch: batch.motions, networks, rows, real, 0)
    assert row["behaviour"]["walks"] == 1 and set(row["non_collision"]) == {"30 mm", "45 mm", "60 mm"}
    assert all(low <= rate <= high for rate, low, high in row["non_collision"].values())
    assert make.text({"captured": row}).count("\n") == 2


def test_points_of_the_floor_are_counted_apart():
    """A camera looks down on a body that stands on the floor: only its feet are in it."""
    turn = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])
    extrinsics = np.eye(4)
    extrinsics[:3, :3], extrinsics[:3, 3] = turn, -turn @ [0.0, 3.0, 0.0]
    depth = np.full((72, 128), 3.0)
    view = CameraView(
        "Above", np.zeros((72, 128, 3), np.uint8), depth, np.array([0.7, 0.5, 9 / 32]), extrinsics
    )
    pose = np.tile([1.0, 0, 0, 0], (2, 22, 1))
    standing = Motion(np.tile([0.0, -human.load().floor, 0.0], (2, 1)), pose)
    found = finished_numbers.points_inside(standing, view, 0.0)
    assert min(found["60 mm"]) > 0 and max(found["60 mm off the floor"]) == 0
    lowered = Motion(standing.root - [0.0, 0.5, 0.0], pose)
    assert min(finished_numbers.points_inside(lowered, view, -1.0)["60 mm off the floor"]) > 0


@pytest.mark.parametrize(
    ("speed", "swing", "walking", "gliding"), [(0.0, 0.5, 0, None), (1.2, 0.0, 0.9, 1), (1.2, 0.5, 0.9, 0)]
)
def test_gaits(speed, swing, walking, gliding):
    """A body that swings its thighs against each other, by radians, once a second, or glides."""
    count = 150
    angle = swing * np.sin(2 * np.pi * np.arange(count) / 30)
    rotations = np.tile([1.0, 0, 0, 0], (count, 22, 1))
    for hip, side in ((1, 1), (2, -1)):
        rotations[:, hip] = np.stack([np.cos(angle / 2), side * np.sin(angle / 2), 0 * angle, 0 * angle], -1)
    root = np.array([0.0, 0.95, 0.0]) + speed / 30 * np.arange(count)[:, None] * [0.0, 0.0, 1.0]
    found = finished_numbers.gait(Motion(root, rotations))
    assert found["walking_share"] == pytest.approx(walking, abs=0.05)
    assert found["gliding_share_of_walking"] == gliding
    if gliding is not None:
        assert (found["ankle_swing_cm"] > 8) == (gliding == 0)


def test_ways_by_speed():
    """Bodies that stand go nowhere, those that walk go on."""
    frames = np.arange(66)[:, None] * np.array([0.0, 0.0, 1.0])
    root = np.stack([0.0 * frames, 0.02 * frames]) + [0.0, 0.95, 0.0]
    found = ways.quantiles(
        np.concatenate([root] * 2 + [root * 0.5 + [0.0, 0.475, 0.0], root * 0.1 + [0, 0.855, 0]])
    )
    assert found.shape == (len(liveliness.SPEEDS) + 1, len(liveliness.SHARES))
    np.testing.assert_allclose(found[0], 0.0, atol=1e-9)
    np.testing.assert_allclose(found[-1], 64 * 0.02, atol=1e-6)
