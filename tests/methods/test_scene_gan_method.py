"""Scene GAN as a method, with networks that stand still or glide: view frames, windows in a row, refusals, takes."""

import numpy as np
import pytest
import scene_gan_room
import torch
from samp_blender.models import weights
from samp_blender.models.scene_gan import networks
from samp_blender.models.scene_gan.projection import Motions
from samp_blender.samp_addon import rotation
from samp_blender.samp_addon.errors import SampError, UsageError
from samp_blender.samp_addon.methods import registry
from samp_blender.samp_addon.methods.method import Draw
from samp_blender.samp_addon.methods.scene_gan import improvisation, load_networks, placing
from samp_blender.samp_addon.methods.scene_gan.frame import ViewFrame, moved, rest_joints
from samp_blender.samp_addon.methods.scene_gan.method import SceneGanMethod
from samp_blender.samp_addon.methods.scene_view import SceneView
from samp_blender.samp_addon.methods.step import Step
from samp_blender.samp_addon.scene.camera_view import CameraView
from samp_blender.samp_addon.scene.navmesh import navmesh
from scene_gan_room import STANDING

TINY = {"width": 32, "noise": 4, "pose_noise": 4, "scene": 16, "encoder_width": 8}
QUIET = lambda stage, share: None


@pytest.fixture(scope="module")
def room():
    return scene_gan_room.room()


@pytest.fixture(scope="module")
def ground(room):
    return scene_gan_room.ground(room)


def camera(depth=8.0):
    """A level camera at (0, 1.6, -6) that looks along +Z."""
    extrinsics = np.eye(4)
    extrinsics[:3, :3] = np.diag([-1.0, -1.0, 1.0])
    extrinsics[:3, 3] = -extrinsics[:3, :3] @ [0.0, 1.6, -6.0]
    colour = np.full((72, 128, 3), 90, np.uint8)
    return CameraView("Shot", colour, np.full((72, 128), depth), np.array([0.7, 0.5, 9 / 32]), extrinsics)


def still(speed=(0.0, 0.0, 0.0), view="geometry"):
    """Networks whose pelvis glides at a speed, metres per frame in the view frame, in the initial pose."""
    made = networks.SceneGan(networks.Settings(**TINY, view=view)).eval()
    with torch.no_grad():
        made.trajectory.last.weight.zero_()
        share = torch.as_tensor(speed) / made.trajectory.alpha
        made.trajectory.last.bias.copy_(torch.atanh(share.float()))
        for part in (made.pose.body, made.pose.rough, made.trajectory.rough):
            for values in part.last.parameters():
                values.zero_()
    return made


def scene(room, **found):
    return SceneView(room, **found)


def test_windows_come_back_to_the_scene():
    frame = ViewFrame.of(camera())
    rng = np.random.default_rng(0)
    quats = rotation.normalise(rng.normal(size=(2, 22, 4)))
    root = np.array([[0.3, 0.9, 1.0], [0.32, 0.91, 1.05]])
    start = frame.start(root, quats, 0.0, rest_joints(), 2)
    np.testing.assert_allclose(start.root[0], [0.32, 0.91 - 1.6, 7.05], atol=1e-5)
    np.testing.assert_allclose(start.root_velocity[0], [0.02, 0.01, 0.05], atol=1e-5)
    motions = Motions.of(start, torch.zeros(2, 3, 64), start.six[:, None].expand(-1, 64, -1, -1))
    roots, turned = frame.to_scene(motions)
    np.testing.assert_allclose(roots[1, -1], root[1], atol=1e-5)
    assert np.abs((turned[0, 0] * quats[1]).sum(-1)).min() > 1 - 1e-5


def test_pictures_are_moved():
    values = np.arange(12).reshape(3, 4)
    np.testing.assert_array_equal(
        moved(values, np.array([1, -1])), [[0, 4, 5, 6], [0, 8, 9, 10], [0, 0, 0, 0]]
    )


@pytest.mark.parametrize(
    "way, height, fine",
    [
        ([[-2, -2], [2, -2]], STANDING, True),  # along the floor
        ([[0, -2], [0, 2]], STANDING, False),  # through the box
        ([[-2, -2], [-2, -4.5]], STANDING, False),  # off the floor
        ([[-2.6, 2.0], [-2.6, 2.0]], 0.62, True),  # seated on the bench
        ([[-2, -2], [-2, -2]], 0.62, False),  # seated on nothing
    ],
)
def test_where_a_body_can_be(ground, way, height, fine):
    share = np.linspace(0, 1, 40)[:, None]
    flat = np.array(way[0]) * (1 - share) + np.array(way[1]) * share
    root = np.stack([flat[:, 0], np.full(40, height), flat[:, 1]], -1)
    assert bool(ground.fits(root, 0.0).all()) is fine


def test_a_take_turns_away_where_it_cannot_go_on(room):
    """Three of four draws glide to the box at different speeds, until a draw stands: it stops before the box."""
    method = SceneGanMethod(still((0.0, 0.0, 0.02)))
    step = Step(action="", method="scene_gan", settings={"seconds": 4.0, "draws": 4})
    view = scene(room, camera=camera(), start=(np.array([0.0, 0.0, -2.5]), 0.0))
    windows = iter([1.0, 1.0, 1.0, *6 * [0.0]])
    networks_ = method._networks
    bias = networks_.trajectory.last.bias.detach().clone()
    draw = networks_.draw

    def slower(*found):
        with torch.no_grad():
            networks_.trajectory.last.bias.copy_(bias * next(windows))
        return draw(*found)

    networks_.draw = slower
    (take,), failures = method.generate(step, view, [Draw(0, 0)], QUIET)
    assert not failures and len(take.motion) == 121
    assert -1.2 < take.motion.root[-1, 2] < -0.6
    assert take.motion.root[:, 2].max() < -0.6


def test_windows_are_joined_without_a_jump():
    time = np.arange(70)[:, None] * [0.01, 0, 0]
    quats = np.tile([1.0, 0, 0, 0], (70, 22, 1))
    made = np.arange(65)[:, None] * [0.02, 0, 0] + time[57]
    root, turned = improvisation.joined(time, quats, made, quats[:65], 57)
    assert root.shape == (57 + 65, 3) and turned.shape == (57 + 65, 22, 4)
    steps = np.diff(root[:, 0])
    assert steps.min() > 0.009 and steps.max() < 0.032 and np.abs(np.diff(steps)).max() < 0.01


def test_a_window_goes_on_as_the_motion_before_it():
    speed, turn = np.array([0.01, 0.0, 0.0]), rotation.about_y(0.02)
    before, turned = np.stack([-speed, 0 * speed]), np.tile([1.0, 0, 0, 0], (2, 22, 1))
    turned[1] = rotation.multiply(turned[0], turn)
    made = np.concatenate([np.zeros((1, 3)), np.arange(1, 65)[:, None] * speed + [0.0, 0.08, 0.0]])
    quats = np.concatenate([turned[1:], np.tile(rotation.about_y(0.9), (64, 22, 1))])
    root, soft = improvisation.continued(made, quats, before, turned)
    np.testing.assert_allclose(root[1], speed, atol=1e-9)
    np.testing.assert_allclose(soft[1], np.tile(rotation.about_y(0.04), (22, 1)), atol=1e-9)
    np.testing.assert_allclose(root[improvisation.EASED + 1 :], made[improvisation.EASED + 1 :], atol=1e-9)
    assert np.abs(np.diff(root[:, 1])).max() < 0.02


def test_a_take_is_as_long_as_asked_for_and_stays_in_view(room):
    method = SceneGanMethod(still((0.0, 0.0, 0.01)))
    view = scene(room, camera=camera(), start=(np.array([-2.0, 0.0, -2.5]), 0.5))
    step = Step(action="", method="scene_gan", settings={"seconds": 5.0})
    takes, failures = method.generate(step, view, [Draw(3, 3), Draw(4, 4)], QUIET)
    assert [take.seed for take in takes] == [3, 4] and not failures
    take = takes[0]
    assert len(take.motion) == 151 and take.camera == "Shot" and take.method == "scene_gan"
    assert take.motion.contacts.shape == (151, 5) and take.motion.actions.shape == (151, 5)
    np.testing.assert_allclose(take.motion.root[0, [0, 2]], [-2.0, -2.5], atol=0.06)
    assert take.motion.root[-1, 2] - take.motion.root[0, 2] == pytest.approx(1.5, abs=0.1)
    joints, _ = take.motion.forward_kinematics()
    assert np.abs(joints[..., 1].min(1)).max() < 0.06  # soles on the floor


def test_a_take_goes_on_from_another(room):
    method = SceneGanMethod(still((0.0, 0.0, 0.01)))
    step = Step(action="", method="scene_gan", settings={"seconds": 2.0})
    view = scene(room, camera=camera(), start=(np.array([-2.0, 0.0, -2.5]), 0.0))
    (first,), _ = method.generate(step, view, [Draw(0, 0)], QUIET)
    (second,), _ = method.generate(step, scene(room, camera=camera(), after={0: first}), [Draw(0, 0)], QUIET)
    assert np.linalg.norm(second.motion.root[0] - first.motion.root[-1]) < 0.03


def test_a_height_map_needs_no_camera(room):
    method = SceneGanMethod(still(view="height"))
    step = Step(action="", method="scene_gan", settings={"seconds": 2.0})
    takes, failures = method.generate(step, scene(room), [Draw(0, 0)], QUIET)
    assert not failures and takes[0].camera is None


@pytest.mark.parametrize(
    "found, speed, message",
    [
        ({"start": (np.array([-2.0, 0.0, -2.5]), 0.0)}, (0, 0, 0), "There is no picture for Improvise; add a camera"),
        ({"camera": camera(), "start": (np.array([-2.9, 0.0, -2.9]), 0.0)}, (0, 0, 0),
         "The character is not in view of camera 'Shot'"),
        ({"camera": camera(3.0), "start": (np.array([0.0, 0.0, -2.0]), 0.0)}, (0, 0, 0),
         "The character is not in view of camera 'Shot'"),
        ({"camera": camera(1.0)}, (0, 0, 0), "Camera 'Shot' sees no free floor"),
        ({"camera": camera(), "start": (np.array([0.0, 0.0, 0.0]), 0.0)}, (0, 0, 0), "does not stand on free floor"),
        ({"camera": camera(), "start": (np.array([0.0, 0.0, -2.0]), 0.0)}, (0, 0, 0.05),
         "No draw out of 3 stays on free floor"),
    ],
)  # fmt: skip
def test_refusals(room, found, speed, message):
    method = SceneGanMethod(still(speed))
    step = Step(action="", method="scene_gan", settings={"seconds": 2.0, "draws": 3})
    try:
        takes, failures = method.generate(step, scene(room, **found), [Draw(0, 0)], QUIET)
    except SampError as error:
        assert message in str(error)
    else:
        assert not takes and message in failures[0].message


@pytest.mark.parametrize("values", [{"target": "Sofa"}, {"to": (0.0, 0.0, 0.0)}])
def test_no_target_and_no_place(values):
    with pytest.raises(UsageError, match="leave"):
        SceneGanMethod().check(Step(action="", method="scene_gan", **values))


def test_characters_are_placed_on_free_floor_in_view(room):
    mesh, view = navmesh.build(room.triangles), camera()
    for seed in range(5):
        place, yaw = placing.free_place(mesh, view, np.random.default_rng(seed))
        assert placing.in_view(view, place[None])[0] and abs(yaw) <= np.pi
        assert not (np.abs(place[[0, 2]]) < [1.0, 0.5]).all()


def test_networks_by_what_there_is_to_see(room, tmp_path, monkeypatch):
    """Height maps where there is no picture; one sentence where there are no networks for that."""
    monkeypatch.setattr(load_networks, "FOLDER", tmp_path)
    monkeypatch.setattr(weights, "FOLDER", tmp_path)
    method, step = SceneGanMethod(), Step(action="", method="scene_gan", settings={"seconds": 1.0})
    networks.save(still(), tmp_path)
    assert method.installed()
    with pytest.raises(SampError, match="The scene has no active camera"):
        method.generate(step, scene(room), [Draw(0, 0)], QUIET)
    networks.save(still(view="height"), tmp_path)
    assert method._tools(False).settings.view == "height" and method._tools(True).settings.view == "geometry"


def test_it_is_offered_only_with_weights(tmp_path):
    there = load_networks.installed() or load_networks.installed(name=load_networks.HEIGHT)
    assert ("scene_gan" in registry.METHODS) is there
    assert not load_networks.installed(tmp_path) and SceneGanMethod(still()).installed()
    with pytest.raises(SampError, match="missing"):
        load_networks.trained(tmp_path)
