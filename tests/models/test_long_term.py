"""Shapes of the long-term networks, and what holds for any weights: exact ends, valid rotations, phases."""

import pytest
import torch
from samp_blender.models.long_term import (
    gait,
    guided_pose,
    guided_route,
    layout,
    point_net,
    pose_prior,
    sub_goal_net,
    window_net,
)

B, N = 3, 40


@pytest.fixture(autouse=True)
def seeded():
    torch.manual_seed(0)


def rotations(*shape):
    return layout.matrix_from_six(torch.randn(*shape, 6))


def test_six_numbers_hold_a_rotation():
    matrix = rotations(50)
    torch.testing.assert_close(layout.matrix_from_six(layout.six_from_matrix(matrix)), matrix)
    torch.testing.assert_close(torch.linalg.det(matrix), torch.ones(50))


@pytest.mark.parametrize("yaw", [-3.0, -0.5, 0.0, 1.2, 3.1])
def test_the_yaw_of_a_tilted_pelvis(yaw):
    tilt = torch.tensor([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])  # lying on the back
    turned = layout.about_y(torch.tensor(yaw))
    for matrix in (turned, turned @ tilt):
        assert float(layout.yaw_of(matrix)) == pytest.approx(yaw, abs=1e-5)


def test_the_prior_returns_rotations():
    net = pose_prior.PosePrior()
    made, mean, _ = net(rotations(B, layout.JOINTS))
    assert made.shape == (B, 21, 3, 3) and mean.shape == (B, 32)
    torch.testing.assert_close(
        made @ made.transpose(-1, -2), torch.eye(3).expand(B, 21, 3, 3), atol=1e-5, rtol=0
    )


def test_a_cloud_is_a_set_in_a_place():
    net, cloud = point_net.PointNet(), torch.randn(B, N, 3)
    assert net(cloud).shape == (B, N, 13)
    code = net.encoder(cloud)
    torch.testing.assert_close(net.encoder(cloud[:, torch.randperm(N)]), code)
    assert (net.encoder(cloud + torch.tensor([0.5, 0.0, 0.0])) - code).abs().max() > 1e-4


def test_sub_goal_bodies():
    net = sub_goal_net.SubGoalNet()
    cloud, betas, given = torch.randn(B, N, 3), torch.randn(B, 10), torch.randn(B, 9)
    still, sits = torch.zeros(B, 2), torch.tensor([[0.0, 1.0, 0.0]] * B)
    body, mean, _ = net(cloud, betas, given, still, sits, torch.randn(B, layout.BODY))
    assert body.shape == (B, 65) and mean.shape == (B, 32)
    condition = net.condition(cloud, betas, given, still, sits)
    assert (net.condition(cloud, betas, given, still, sits.flip(-1).roll(1, -1)) - condition).abs().max() > 0
    assert (net.decode(condition, given, mean) - net.decode(condition, given, mean + 1)).abs().max() > 0


def test_bodies_are_asked_for_as_captured_ones_are_turned():
    net = sub_goal_net.SubGoalNet()
    net.turns[2, 5] = torch.tensor([0.0, 1.0, 0.0, 0.0, 0.0, -1.0, 0.04])
    rows = torch.tensor([5, 6])
    given = net.given("lie", torch.tensor([0.6, 0.6]), rows)
    torch.testing.assert_close(given[0], torch.tensor([0.0, 0.64, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0]))
    upright = torch.tensor([0.0, 0.6, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0])
    torch.testing.assert_close(given[1], upright)
    torch.testing.assert_close(net.given("sit", torch.tensor([0.6, 0.6]), rows)[0], upright)


@pytest.mark.parametrize("yaw", [-2.0, 0.0, 1.2])
@pytest.mark.parametrize("roll", [0.0, 90.0, 180.0, -90.0])
def test_a_lying_body_faces_from_head_to_feet(yaw, roll):
    back = torch.tensor([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])  # on the back, the head towards -Z
    turn = torch.tensor(roll).deg2rad()
    cos, sin = torch.cos(turn), torch.sin(turn)
    about_z = torch.stack(
        [torch.stack([cos, -sin, 0 * cos]), torch.stack([sin, cos, 0 * cos]), torch.tensor([0.0, 0, 1])]
    )
    matrix = layout.about_y(torch.tensor(yaw)) @ about_z @ back
    assert float(layout.lying_yaw_of(matrix)) == pytest.approx(yaw, abs=1e-5)


@pytest.mark.parametrize("scene", [False, True])
@pytest.mark.parametrize(
    "net, ends, route, outputs",
    [
        (window_net.route_net, 9, 0, 9),
        (lambda scene: window_net.route_net(False, scene), 9, 0, 3),
        (lambda scene: window_net.pose_net(scene=scene), 56, 9, 56),
        (lambda scene: window_net.pose_net(True, False, scene), 62, 0, 62),
        (window_net.base_net, 65, 0, 65),
    ],
)
def test_networks_of_the_paper(net, ends, route, outputs, scene):
    made = net(scene=scene)
    given = torch.randn(B, 59, route) if route else None
    frames = made(torch.randn(B, ends), torch.randn(B, ends), torch.randn(B, N, 3), given)
    assert frames.shape == (B, 59, outputs)


def ends():
    path = torch.linspace(0, 2, 16)[None, :, None].expand(B, -1, 2).contiguous()
    pose = lambda place: torch.cat([place, layout.six_from_matrix(rotations(B))], -1)
    start, end = pose(torch.tensor([[0.0, 0.9, 0.0]] * B)), pose(torch.tensor([[2.0, 0.5, 2.0]] * B))
    return guided_route.RouteEnds(start, end, path, torch.randn(B, 10), torch.randn(B, 2), torch.randn(B, 2))


@pytest.mark.parametrize("frames", [2, 20, 61, 90])
def test_guided_networks_hold_both_ends(frames):
    known, cloud, z = ends(), torch.randn(B, N, 3), torch.randn(B, 8)
    net = guided_route.GuidedRoute()
    route = net(known, frames, cloud, z)
    assert route.shape == (B, frames, 9)
    torch.testing.assert_close(route[:, 0], known.start)
    torch.testing.assert_close(route[:, -1], known.end)
    pose = guided_pose.GuidedPose()
    still = guided_pose.PoseEnds(torch.randn(B, 150), torch.randn(B, 150), torch.randn(B, 10))
    poses = pose(still, route, torch.randn(B, frames, 2), cloud, z)
    torch.testing.assert_close(poses[:, 0], still.start)
    torch.testing.assert_close(poses[:, -1], still.end)
    assert (net.seconds(known) > 0).all() and net.posterior(known, route)[0].shape == (B, 8)
    if frames > 2:
        assert (net(known, frames, cloud, z + 1) - route).abs().max() > 1e-5


def walker(phase, yaw=0.0):
    """Joints of a walker of this phase, radians, at the usual stride."""
    joints = torch.zeros(len(phase), 22, 3)
    ahead, lift = gait.STRIDE / 2 * torch.cos(phase), gait.LIFT * torch.sin(phase)
    for joint, sign in ((7, 1), (8, -1)):
        joints[:, joint, 0] = sign * ahead * torch.sin(torch.tensor(yaw))
        joints[:, joint, 2] = sign * ahead * torch.cos(torch.tensor(yaw))
        joints[:, joint, 1] = (-sign * lift).clamp(min=0)
    return joints


@pytest.mark.parametrize("yaw", [0.0, 1.0, -2.5])
def test_the_phase_of_a_walk_goes_on(yaw):
    phase = torch.linspace(0, 12, 200)
    read = gait.phase_of(walker(phase, yaw), torch.full((200,), yaw))
    torch.testing.assert_close(gait.unwrapped(read[None])[0], phase, atol=1e-3, rtol=0)


@pytest.mark.parametrize("length, turns", [(0.1, 0), (1.15, 1), (2.4, 2)])
def test_strides_of_usual_length(length, turns):
    gaits = torch.tensor([[1.0, 0.0]])
    total = gait.advance(gaits, gaits, torch.tensor([length]))
    assert float(total) == pytest.approx(turns * 2 * torch.pi)
    route = torch.zeros(1, 40, 3)
    route[0, :, 2] = torch.linspace(0, length, 40)
    planned = gait.planned(gaits, total, route)
    assert planned.shape == (1, 40, 2)
    if turns:
        assert float(gait.unwrapped(planned)[0, -1]) == pytest.approx(turns * 2 * torch.pi, abs=1e-3)
