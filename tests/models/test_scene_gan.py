"""Scene GAN's networks: shapes of the paper's tables, kinematics, noise, projection, crops."""

import numpy as np
import pytest
import torch
from samp_blender.models import weights
from samp_blender.models.scene_gan import (
    critics,
    height_map,
    joint_graph,
    kinematics,
    layers,
    networks,
    noise,
    projection,
    scene_encoder,
)
from samp_blender.models.scene_gan.projection import Motions
from samp_blender.models.scene_gan.start import SIZE, Start
from samp_blender.samp_addon import skeleton

TINY = {"width": 32, "noise": 8, "pose_noise": 8, "scene": 16, "encoder_width": 8}
LENS = (0.7, 0.5, 9 / 32)


def start(count=2, place=(0.0, -0.3, 3.0)):
    """Bodies in rest pose in front of a level camera, 3 m away."""
    rows = lambda values, *shape: torch.as_tensor(values, dtype=torch.float32).expand(count, *shape)
    still = torch.tensor([1.0, 0, 0, 0, 1, 0])
    rest = torch.as_tensor(np.array(skeleton.default_rest_joints()[:22]), dtype=torch.float32)
    camera = torch.tensor([[-1.0, 0, 0, 0], [0, -1, 0, 0], [0, 0, 1, 0]])
    return Start(
        rows(still, 22, 6), rows(place, 3), rows(rest, 22, 3), torch.zeros(count, 22, 3), torch.zeros(count, 3),
        torch.full((count,), 0.9), rows(camera, 3, 4), rows(LENS, 3),
    )  # fmt: skip


def test_kinematics_are_those_of_the_program():
    rng = np.random.default_rng(0)
    quats = rng.normal(size=(3, 22, 4))
    quats /= np.linalg.norm(quats, axis=-1, keepdims=True)
    rest = skeleton.default_rest_joints()
    expected, _ = skeleton.forward_kinematics(np.zeros((3, 3)), quats, rest)
    turned = kinematics.quaternion_matrices(torch.as_tensor(quats))
    again = kinematics.matrices(kinematics.six_numbers(turned))
    made = kinematics.joint_positions(again, torch.as_tensor(np.array(rest[:22])))
    np.testing.assert_allclose(made.numpy(), expected, atol=1e-6)
    assert tuple(skeleton.PARENTS[:22]) == kinematics.PARENTS


@pytest.mark.parametrize("source, target", [(22, 22), (22, 11), (11, 5), (5, 1), (5, 5), (5, 11), (11, 22)])
def test_links_share_each_node_once(source, target):
    own, near = joint_graph.links(source, target)
    assert own.shape == (target, source)
    torch.testing.assert_close(own.sum(1), torch.ones(target))
    assert ((near.sum(1) - 1).abs() < 1e-6).logical_or(near.sum(1) == 0).all()
    assert not ((own > 0) & (near > 0)).any() or target > source


def test_noise_is_smoother_in_later_channels():
    process = noise.GaussianProcess(16)
    drawn = process.draw(4000, torch.Generator().manual_seed(0))
    assert drawn.shape == (4000, 16, noise.STEPS)
    next_to = (drawn[:, :, 0] * drawn[:, :, 1]).mean(0)
    for channel, sigma in ((0, noise.SHORTEST), (-1, noise.LONGEST)):
        assert float(next_to[channel]) == pytest.approx(np.exp(-1 / (2 * sigma**2)), abs=0.06)
    assert (drawn.var(0) - 1).abs().max() < 0.15


@pytest.mark.parametrize("settings", [{}, {"separate": False}, {"view": "geometry"}, {"view": "height"}])
def test_windows_begin_in_the_start_and_move_at_most_alpha(settings):
    made = networks.SceneGan(networks.Settings(**TINY, **settings))
    begin = start()
    motions = made.draw(torch.randn(2, 16), begin, torch.Generator().manual_seed(0))
    assert motions.root.shape == (2, 65, 3) and motions.positions.shape == (2, 65, 22, 3)
    torch.testing.assert_close(motions.root[:, 0], begin.root)
    torch.testing.assert_close(motions.six[:, 0], begin.six)
    assert (motions.velocities.abs() <= torch.tensor([0.1, 0.06, 0.1])[:, None] + 1e-5).all()
    assert begin.condition().shape == (2, SIZE)


@pytest.mark.parametrize("name", ["TrajectoryCritic", "PoseCritic", "ProjectionCritic", "ContextCritic"])
def test_critics_give_the_generators_gradients(name):
    settings = networks.Settings(**TINY)
    made, critic, begin = networks.SceneGan(settings), getattr(critics, name)(settings.sizes), start()
    motions = made.draw(torch.randn(2, 16), begin)
    more = (torch.rand(2, 1, 36, 64) + 2,) if name == "ContextCritic" else ()
    scores = critic(critic.inputs(motions, begin, *more), torch.randn(2, 16), begin)
    assert scores.shape == (2,)
    scores.sum().backward()
    slopes = [p.grad.abs().sum() for p in made.trajectory.parameters() if p.grad is not None]
    assert slopes and sum(slopes) > 0


def test_places_in_the_picture():
    begin = start(1)
    points = torch.tensor([[[0.0, 0, 3], [-1.0, 0, 2], [0.0, 0.5, 2], [0, 0, -5]]])
    places = projection.project(points, begin)[0]
    torch.testing.assert_close(places[0], torch.tensor([0.5, 9 / 32]))
    torch.testing.assert_close(places[1], torch.tensor([0.5 + 0.35, 9 / 32]))  # +X is to the left
    assert places[2, 1] < 9 / 32 and places.isfinite().all()


def test_crops_follow_the_body():
    """A wall 1 m behind the body; where the body walks into a near box, the crop says so."""
    begin = start(1)
    depth = torch.full((1, 1, 36, 64), 4.0)
    depth[..., 40:] = 2.0  # right of the picture
    still = torch.zeros(1, 3, 64)
    six = begin.six[:, None].expand(-1, 64, -1, -1)
    crops = projection.relative_depth(Motions.of(begin, still, six), begin, depth, (9, 16))
    assert crops.shape == (1, 9, 9, 16)
    torch.testing.assert_close(crops[0, 0, 4, 7], torch.tensor(1.0))
    right = torch.zeros(1, 3, 64)
    right[:, 0] = -0.03
    moved = projection.relative_depth(Motions.of(begin, right, six), begin, depth, (9, 16))
    assert moved[0, -1, 4, 8] < 0 < moved[0, 0, 4, 8]


def test_normals_of_a_wall_and_a_floor():
    depth = torch.full((1, 18, 32), 3.0)
    normal = scene_encoder.normals_of(depth, torch.tensor([LENS]))
    torch.testing.assert_close(normal[0, 4, 5], torch.tensor([0.0, 0.0, -1.0]))
    rows = (torch.arange(18) + 0.5) / 32 - 9 / 32
    floor = torch.where(rows > 0.02, 0.7 * 1.2 / rows.clamp(min=0.02), torch.zeros(18))
    normal = scene_encoder.normals_of(floor[None, :, None].expand(1, 18, 32), torch.tensor([LENS]))
    torch.testing.assert_close(normal[0, 15, 5], torch.tensor([0.0, -1.0, 0.0]), atol=1e-4, rtol=0)
    assert (normal[0, 0] == 0).all()


@pytest.mark.parametrize("yaw, cell", [(0.0, (24, 40)), (np.pi / 2, (8, 24))])
def test_height_maps_turn_with_the_view(yaw, cell):
    """A box 1.6 m along Z of the room: ahead of a view along Z, on the right of one along X."""
    grid = torch.zeros(1, 1, 120, 120)
    grid[:, :, 58:62, 90:94] = 0.5
    corner, place = torch.full((1, 2), -3.0), torch.zeros(1, 2)
    made = height_map.around(grid, corner, 0.05, place, torch.tensor([yaw]))
    assert made.shape == (1, 2, 48, 48) and (made[:, 1] == 1).all()
    rows, columns = (made[0, 0] > 0.4).nonzero(as_tuple=True)
    assert (abs(rows.float().mean() + 0.5 - cell[0]) < 1.1) and abs(
        columns.float().mean() + 0.5 - cell[1]
    ) < 1.1


def test_encoder_keeps_published_names_and_decodes():
    made = networks.encoder(networks.Settings(**TINY))
    published = {name: value.clone() + 0.01 for name, value in made.trunk.state_dict().items()}
    assert "layer2.0.downsample.0.weight" in published and "layer4.1.bn2.running_var" in published
    made.load_published(published | {"fc.weight": torch.zeros(3), "fc.bias": torch.zeros(3)})
    torch.testing.assert_close(made.trunk.conv1.weight, published["conv1.weight"])
    feature = made(scene_encoder.normalised(torch.zeros(2, 72, 128, 3, dtype=torch.uint8)))
    depth, normal, classes = made.decoder(feature)
    assert depth.shape == (2, 1, 36, 64) and (depth > 0).all()
    assert classes.shape[1] == 13 and normal.norm(dim=1).allclose(torch.ones(()), atol=1e-4)


def test_weights_are_read_back(tmp_path):
    settings = networks.Settings(**TINY, view="height")
    made = networks.SceneGan(settings)
    path = networks.save(made, tmp_path)
    again = networks.load(tmp_path)
    assert again.settings == settings and not again.training
    torch.testing.assert_close(
        again.pose.body.last.mix.weight, made.pose.body.last.mix.weight, atol=1e-3, rtol=1e-2
    )
    path.with_suffix(".json").write_text("{}")
    with pytest.raises(weights.WeightsError):
        networks.load(tmp_path)


@pytest.mark.parametrize("shape", [(2, 3, 4), (2, 3, 5, 8)])
def test_twice_as_long_is_linear_interpolation(shape):
    x = torch.randn(shape, generator=torch.Generator().manual_seed(0))
    flat = x.reshape(shape[0], -1, shape[-1])
    known = torch.nn.functional.interpolate(flat, scale_factor=2, mode="linear", align_corners=False)
    torch.testing.assert_close(layers.twice_as_long(x), known.view(*shape[:-1], 2 * shape[-1]))
