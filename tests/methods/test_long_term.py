"""The long-term method around its networks, which have random weights here: places, ways, exact ends, refusals."""

from dataclasses import replace

import numpy as np
import pytest
import rooms
import torch
from samp_blender.models.long_term import guided_pose, guided_route, pose_prior, sub_goal_net
from samp_blender.samp_addon import rotation
from samp_blender.samp_addon.body import hand_poses, human
from samp_blender.samp_addon.errors import SampError, UsageError
from samp_blender.samp_addon.methods.long_term import joining, planning, way
from samp_blender.samp_addon.methods.long_term.figure import Figure, as_motion
from samp_blender.samp_addon.methods.long_term.method import LongTerm
from samp_blender.samp_addon.methods.long_term.networks import Crossing, Networks, noises
from samp_blender.samp_addon.methods.long_term.sub_goals import places
from samp_blender.samp_addon.methods.long_term.surfaces import Surfaces
from samp_blender.samp_addon.methods.method import Draw
from samp_blender.samp_addon.methods.scene_view import SceneView
from samp_blender.samp_addon.methods.step import Step
from samp_blender.samp_addon.scene.geometry import SceneGeometry
from samp_blender.samp_addon.scene.navmesh import navmesh

SEAT, BED, WALL = (2.0, 0.45, 2.0), (-2.2, 0.5, 1.5), (0.0, 0.0, -2.5)
QUIET = lambda stage, share: None


@pytest.fixture(scope="module")
def geometry():
    """A floor of 8 m with a seat with a back (faces -Z), a bed (its head towards +Z) and a wall."""
    boxes = {
        "floor": [((-4, -0.1, -4), (4, 0, 4))],
        "seat": [((1.6, 0.3, 1.75), (2.4, 0.45, 2.3)), ((1.6, 0.45, 2.25), (2.4, 0.95, 2.35))],
        "bed": [((-2.7, 0.2, 0.4), (-1.7, 0.5, 2.6))],
        "wall": [((-1.5, 0.0, -2.8), (1.5, 2.5, -2.2))],
        "post": [((2.9, 0.0, -3.1), (3.1, 1.2, -2.9))],
    }
    return SceneGeometry.from_objects(
        [(name, np.concatenate([rooms.box(*box) for box in parts])) for name, parts in boxes.items()]
    )


@pytest.fixture(scope="module")
def mesh(geometry):
    return navmesh.build(geometry.triangles)


@pytest.fixture(scope="module")
def networks():
    torch.manual_seed(3)
    nets = (
        pose_prior.PosePrior(),
        sub_goal_net.SubGoalNet(),
        guided_route.GuidedRoute(),
        guided_pose.GuidedPose(),
    )
    return Networks(*(net.eval() for net in nets))


def find(geometry, mesh, point, yaw=0.0):
    return places.find(Surfaces(geometry.triangles, mesh), np.array(point), np.radians(yaw), "Sub-goal 1")


@pytest.mark.parametrize(
    "point, yaw, action, height",
    [
        ((0.0, 0.0, 0.0), 30, "idle", places.standing_height()),
        ((2.0, 0.45, 1.95), 180, "sit", 0.63),
        ((2.0, 0.5, 1.95), 180, "sit", 0.63),
        ((-2.2, 0.5, 1.4), 180, "lie", 0.62),
    ],
)
def test_what_carries_the_body(geometry, mesh, point, yaw, action, height):
    place = find(geometry, mesh, point, yaw)
    assert place.action == action and place.pelvis[1] == pytest.approx(height, abs=0.02)
    assert place.floor[1] == pytest.approx(0.0, abs=0.03)
    assert np.linalg.norm((place.pelvis - point)[[0, 2]]) < 0.2


@pytest.mark.parametrize(
    "point, message",
    [
        ((0.0, 1.2, 0.0), "Sub-goal 1 is in the air; put it onto a floor, a seat or a bed."),
        (WALL, "Sub-goal 1 is inside a wall or too close to something; move it onto free floor."),
        ((3.0, 1.2, -3.0), "nobody can sit or lie"),
    ],
)
def test_points_that_cannot_be_sub_goals(geometry, mesh, point, message):
    with pytest.raises(SampError, match=message):
        find(geometry, mesh, point)


def test_a_way_around_the_wall(mesh):
    start, end = np.array([0.0, 0.0, -3.4]), np.array([0.0, 0.0, -1.0])
    line = way.between(mesh, start, end)
    assert line.shape == (16, 3)
    np.testing.assert_allclose(line[[0, -1]][:, [0, 2]], [[0, -3.4], [0, -1]], atol=1e-6)
    assert np.abs(line[:, 0]).max() > 1.5
    steps = np.linalg.norm(np.diff(line, axis=0), axis=-1)
    assert steps.max() < 1.3 * steps.min()
    straight = way.between(mesh, np.array([0.0, 0, 0]), np.array([1.0, 0, 0.5]))
    assert np.abs(np.cross(straight[:, [0, 2]], [1.0, 0.5])).max() < 1e-6


def test_places_between_where_a_window_cannot_reach(geometry, mesh):
    stops = [find(geometry, mesh, (-3.0, 0.0, -3.4), 90), find(geometry, mesh, (2.0, 0.45, 1.95), 180)]
    (leg,) = planning.legs(mesh, stops, np.random.default_rng(0), 0.0)
    assert leg.stops[-1] is stops[1] and len(leg.stops) >= 3
    assert not any(stop.fixed for stop in leg.stops[:-1])
    for path in leg.paths:
        assert np.linalg.norm(np.diff(path[:, [0, 2]], axis=0), axis=-1).sum() <= planning.REACH + 0.9
    np.testing.assert_allclose(leg.paths[-1][-1][[0, 2]], stops[1].floor[[0, 2]])
    # The last body between stands in front of the seat.
    assert np.linalg.norm((leg.stops[-2].pelvis - stops[1].pelvis)[[0, 2]]) > 0.8


def figure(root, yaw=0.0):
    rotations = np.zeros((22, 4))
    rotations[:, 0] = 1
    rotations[0] = [np.cos(yaw / 2), 0, np.sin(yaw / 2), 0]
    return Figure(np.array(root), rotations, hand_poses.code("relaxed"), np.zeros(10))


def test_a_window_holds_both_bodies(networks):
    start, end = figure((1.0, 0.93, -1.0), 0.7), figure((2.0, 0.9, 0.5), -1.0)
    end = replace(end, hands=hand_poses.code("fist"))
    line = way.resampled(np.array([start.root, end.root]))
    crossing = Crossing(start, end, line, (True, False), 1.0, noises(np.random.default_rng(0), 1.0))
    cloud = np.random.default_rng(0).uniform(-2, 2, (512, 3))
    motion = networks.cross(crossing, cloud)
    assert 14 <= len(motion) <= 90
    for frame, body in ((0, start), (-1, end)):
        np.testing.assert_allclose(motion.root[frame], body.root, atol=1e-5)
        whole = hand_poses.with_hands(body.rotations[None], body.hands[None])[0]
        dot = np.abs((motion.rotations[frame] * whole).sum(-1))
        np.testing.assert_allclose(dot, 1, atol=1e-6)
    assert len(networks.cross(crossing, cloud, 33)) == 33


@pytest.fixture(scope="module")
def scene(geometry):
    points = [((0.5, 0.0, -1.0), 0.0), ((2.0, 0.45, 1.95), np.pi), ((-1.0, 0.0, 0.0), 1.0)]
    return SceneView(geometry, sub_goals=[(np.array(point), yaw) for point, yaw in points])


SETTINGS = {"sub_goals": ((0.5, 1.0, 0.0, 0.0), (2.0, -1.95, 0.45, 180.0), (-1.0, 0.0, 0.0, 57.0))}


def test_takes_through_all_sub_goals(networks, scene):
    step = Step(action="", method="long_term", settings=SETTINGS, hold=0.5)
    takes, failures = LongTerm(networks).generate(step, scene, [Draw(4, 4), Draw(5, 5)], QUIET)
    assert not failures and [take.seed for take in takes] == [4, 5]
    for take in takes:
        assert take.method == "long_term" and np.isfinite(take.motion.root).all()
        assert take.motion.contacts.shape == (len(take.motion), 5)
        np.testing.assert_allclose(take.motion.actions.sum(1), 1)
        assert [place.frame for place in take.sub_goals] == sorted(place.frame for place in take.sub_goals)
        assert len(take.sub_goals) == 3
        fingers = take.motion.rotations[:, 25:]
        assert fingers.shape[1] == 30 and np.abs(np.diff(fingers, axis=0)).max(axis=(1, 2)).mean() > 1e-5
        for place in take.sub_goals:
            assert np.linalg.norm(take.motion.root[place.frame] - place.position) < 0.3
        np.testing.assert_allclose(take.goal.position, take.sub_goals[-1].position)
    assert len(takes[0].motion) != len(takes[1].motion) or (
        np.abs(takes[0].motion.root - takes[1].motion.root).max() > 1e-3
    )


def test_the_same_seed_makes_the_same_take(networks, scene):
    step = Step(action="", method="long_term", settings=SETTINGS, hold=0.2)
    made = [LongTerm(networks).generate(step, scene, [Draw(4, 4)], QUIET)[0][0] for _ in range(2)]
    np.testing.assert_array_equal(made[0].motion.root, made[1].motion.root)


def test_a_sub_goal_that_nobody_can_reach(networks, geometry):
    fence = [rooms.box((1.5, 0, -1.5), (3.5, 1, -1.4)), rooms.box((1.5, 0, 0.4), (3.5, 1, 0.5))]
    fence += [rooms.box((1.5, 0, -1.5), (1.6, 1, 0.5)), rooms.box((3.4, 0, -1.5), (3.5, 1, 0.5))]
    walled = SceneGeometry.from_objects([("room", np.concatenate([geometry.triangles, *fence]))])
    points = [((0.0, 0.0, 0.0), 0.0), ((2.5, 0.0, -0.5), 0.0)]
    scene = SceneView(walled, sub_goals=[(np.array(point), yaw) for point, yaw in points])
    step = Step(action="", method="long_term", settings={"sub_goals": ((0, 0, 0, 0), (2.5, 0.5, 0, 0))})
    takes, failures = LongTerm(networks).generate(step, scene, [Draw(1, 1)], QUIET)
    assert not takes and failures[0].message.startswith("Sub-goal 2 cannot be reached from sub-goal 1: ")


def test_takes_pass_the_bodies_that_were_chosen(networks, scene, geometry, mesh):
    bodies = LongTerm(networks).bodies(scene)
    places_ = [bodies.place(point, yaw, "Here") for point, yaw in scene.sub_goals]
    chosen = [bodies.draw(place, number, 0.1) for number, place in enumerate(places_)]
    step = Step(action="", method="long_term", hold=0.2)
    view = replace(scene, bodies=[chosen[0], chosen[1], None])
    (take,), _ = LongTerm(networks).generate(step, view, [Draw(4, 4)], QUIET)
    for passed, body in zip(take.sub_goals[:2], chosen[:2], strict=True):
        np.testing.assert_allclose(passed.position, body.root[0], atol=1e-9)
    assert np.linalg.norm(take.sub_goals[2].position - chosen[2].root[0]) < 0.5


def test_a_pose_stands_on_the_floor_and_touches_the_seat(networks, scene):
    bodies = LongTerm(networks).bodies(scene)
    pose = as_motion([figure((5.0, 3.0, 5.0), 0.4)])
    for point, yaw in scene.sub_goals:
        place = bodies.place(point, yaw, "Here")
        posed = bodies.posed(place, pose)
        np.testing.assert_allclose(posed.root[0, [0, 2]], place.pelvis[[0, 2]])
        same = np.abs((posed.rotations[0, 1:] * pose.rotations[0, 1:]).sum(-1))
        np.testing.assert_allclose(same, 1, atol=1e-9)
        assert np.dot(posed.headings()[0], place.goal.direction) > 0.999
        if place.action == "idle":
            lowest = human.skin(human.load(), posed)[0, :, 1].min()
            assert lowest == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize(
    "point, wanted, expected",
    [((0.0, 0.0, 0.0), 0.7, 0.7), ((2.0, 0.45, 1.95), 0.0, np.pi), ((-2.2, 0.5, 1.4), 0.3, None)],
)
def test_the_facing_of_a_new_sub_goal(networks, scene, point, wanted, expected):
    yaw = LongTerm(networks).bodies(scene).facing(np.array(point), wanted, "Here")
    if expected is None:  # along the bed, which has no headboard: either way
        assert abs(np.sin(yaw)) < 0.3
    else:
        assert abs(np.angle(np.exp(1j * (yaw - expected)))) < 0.1


@pytest.mark.parametrize(
    "count, message",
    [(0, "There are no sub-goals; add some"), (1, "There is only one sub-goal; add another")],
)
def test_too_few_sub_goals_in_the_scene(networks, scene, count, message):
    step = Step(action="", method="long_term")
    with pytest.raises(SampError, match=message):
        LongTerm(networks).generate(
            step, replace(scene, sub_goals=scene.sub_goals[:count]), [Draw(1, 1)], QUIET
        )


@pytest.mark.parametrize(
    "values, message",
    [
        ({"action": "", "settings": {"sub_goals": ((0, 0, 0, 0),)}}, "only one --sub-goal"),
        ({"action": "", "settings": {"sub_goals": ((0, 0, 0, 0), (0, 0, 0))}}, "needs the numbers X Y Z YAW"),
        ({"action": "", "target": "Sofa"}, "Say what to do at the end with --action"),
        ({"action": "run", "to": (0, 0, 0)}, "no action 'run'"),
        ({"action": "sit"}, "Name what to sit on"),
        ({"action": "walk"}, "Say where to walk"),
        ({"target": "Sofa", "settings": SETTINGS}, "leave out --target"),
    ],
)
def test_steps_that_cannot_be_made(values, message):
    with pytest.raises(UsageError, match=message):
        LongTerm().check(Step(**{"method": "long_term", **values}))


@pytest.mark.parametrize("kind", hand_poses.KINDS)
def test_hands(kind):
    code = hand_poses.code(kind)
    quats = hand_poses.rotations(code)
    assert code.shape == (24,) and quats.shape == (30, 4)
    bend = 2 * np.arccos(np.clip(np.abs(quats[:12, 0]), 0, 1))
    expected = {"relaxed": (8, 35), "fist": (65, 90), "flat": (0, 10)}[kind]
    assert expected[0] <= np.degrees(np.median(bend)) <= expected[1]
    np.testing.assert_allclose(hand_poses.codes(quats), code, atol=1e-9)
    mirrored = quats[:15] * [1.0, 1.0, -1.0, -1.0]
    np.testing.assert_allclose(mirrored, quats[15:], atol=1e-9)


def swinging(pace, first, count=40):
    """Return frames of a walker at a pace in metres per frame, one leg swinging, from a frame on."""
    time = np.arange(first, first + count) * 1.0
    body = figure((0.0, 0.93, 0.0))
    motion = as_motion([body] * count)
    rotations = motion.rotations.copy()
    rotations[:, 1] = rotation.from_axis_angle(np.outer(0.5 * np.sin(10 * pace * (time - 39)), [1.0, 0, 0]))
    return replace(motion, root=motion.root + np.outer(pace * (time - 39), [0, 0, 1.0]), rotations=rotations)


@pytest.mark.parametrize("paces", [(0.04, 0.02), (0.02, 0.04), (0.04, 0.0)])
def test_a_window_goes_on_with_the_velocity_of_the_one_before(paces):
    before, after = swinging(paces[0], 0), swinging(paces[1], 39)
    made, ends = joining.joined([joining.Part(before, "walk", "walk"), joining.Part(after, "walk", "walk")])
    assert ends == [39, 78]
    joints = made.forward_kinematics()[0]
    here = before.forward_kinematics()[0][-1]
    assert np.linalg.norm(joints[39] - here, axis=-1).max() < 0.01
    # The speed at the seam is the mean of both, without a jump; away from it the windows stay as they are.
    speed = np.linalg.norm(np.diff(made.root, axis=0), axis=-1)
    assert speed[38:40] == pytest.approx(np.full(2, sum(paces) / 2), abs=0.003)
    assert np.abs(np.diff(speed)).max() < 0.2 * abs(paces[0] - paces[1])
    np.testing.assert_allclose(
        made.root[[0, 15, 64, 78]], [*before.root[[0, 15]], *after.root[[25, 39]]], atol=1e-4
    )
    bent = lambda motion: np.abs(np.diff(rotation.to_axis_angle(motion.rotations[:, 1])[:, 0], 2)).max()
    own, jump = max(bent(before), bent(after)), 5 * abs(paces[0] - paces[1])
    assert bent(made) < own + 0.2 * jump
