"""Finishing of a raw rollout: its end on the goal, without a pop; and the route that it follows."""

from dataclasses import replace

import numpy as np
import pytest
from samp_blender.samp_addon import frames, rotation
from samp_blender.samp_addon.methods.samp.finishing import finish, high_seat
from samp_blender.samp_addon.methods.samp.finishing.resting import RestingTop
from samp_blender.samp_addon.methods.samp.route import STANDS_AHEAD, Route, Routes
from samp_blender.samp_addon.motion import Goal, Motion
from samp_blender.samp_addon.scene.geometry import sample_surface
from shapes import box

FRAMES, WALK = 150, 100


def glide(action):
    """Return a body that glides 3 m along +Z, then stands still, or sinks by 30 cm over 20 frames to sit."""
    root = np.zeros((FRAMES, 3))
    root[:, 2] = np.minimum(np.arange(FRAMES) / WALK, 1) * 3
    root[:, 1] = 0.93
    actions = np.zeros((FRAMES, 5))
    actions[:WALK, 1], actions[WALK:, 0] = 1, 1
    if action == "sit":
        root[:, 1] -= 0.3 * np.clip((np.arange(FRAMES) - WALK) / 20, 0, 1)
        actions[WALK:] = [0, 0, 0, 1, 0]
    quats = np.zeros((FRAMES, 22, 4))
    quats[..., 0] = 1
    motion = Motion(root, quats, actions=actions, contacts=np.zeros((FRAMES, 5)))
    start = finish.interaction_start(motion, action)
    return Motion(root, quats, actions=actions, contacts=np.zeros((FRAMES, 5)), interaction_start=start)


@pytest.mark.parametrize("action", ["sit", "idle"])
@pytest.mark.parametrize("shift", [(0, 0, 0), (0.12, 0.05, -0.1), (-0.2, -0.08, 0.15)])
@pytest.mark.parametrize("turn", [0, 25, -40])
def test_the_take_ends_on_its_goal_without_a_pop(action, shift, turn):
    motion = glide(action)
    position = motion.root[-1] + np.array(shift) * ([1, 1, 1] if action == "sit" else [1, 0, 1])
    goal = np.concatenate([position, frames.yaw_direction(np.radians(turn)), np.zeros(5)])
    settled = finish.settle_on_goal(motion, goal, action)
    assert np.abs(settled.root[-1] - position).max() < 1e-3
    facing = rotation.rotate(settled.rotations[-1, 0], np.array([0.0, 0, 1]))
    assert np.degrees(np.arccos(np.clip(facing @ goal[3:6], -1, 1))) < 0.1
    assert np.allclose(settled.root[:30], motion.root[:30]) and np.allclose(
        settled.rotations[:30], motion.rotations[:30]
    )
    added = np.diff(settled.root - motion.root, axis=0)
    assert np.abs(added).max() < 0.025, "less than 2.5 cm of the error may be removed per frame"


def test_interaction_start():
    assert finish.interaction_start(glide("sit"), "sit") == WALK
    assert finish.interaction_start(glide("idle"), "idle") is None


def test_route_drops_corners_near_the_goal_and_ends_on_it():
    goal = Goal(np.array([2.0, 0.6, 3.0]), np.array([1.0, 0, 0]))
    corners = np.array([[0, 0, 0], [0, 0, 3.0], [1.7, 0, 3.0]])
    route = Route(np.zeros(3), corners, goal, "sit")
    assert len(route.goals) == 2 and route.length == pytest.approx(3 + 2 + STANDS_AHEAD)
    assert np.allclose(
        route.goals[0], [0, 0, 3, 1.7 / np.hypot(1.7, 3), 0, 3 / np.hypot(1.7, 3), 0, 1, 0, 0, 0]
    )
    assert np.allclose(route.goals[1], [2, 0.6, 3, 1, 0, 0, 0, 0, 0, 1, 0])
    assert np.allclose(
        Routes([route]).at(np.array([[-1.0, 1.0, 4.0, 9.0]]))[0],
        [[0, 0], [0, 1], [1, 3], [2 + STANDS_AHEAD, 3]],
    )
    assert route.end_yaw == pytest.approx(np.pi / 2)


@pytest.mark.parametrize("side", [1, -1])
def test_the_route_to_a_bed_ends_beside_it_and_faces_away(side):
    goal = Goal(np.array([0.0, 0.6, 0.0]), np.array([0.0, 0, 1.0]), "lie")
    beside = np.array([side * 0.9, 0.0, 0.2])
    route = Route(np.array([side * 3.0, 0, 0]), np.array([[side * 3.0, 0, 0], beside]), goal, "lie")
    assert np.allclose(route.points[-1], beside) and len(route.goals) == 1
    assert np.degrees(route.end_yaw) == pytest.approx(side * 90)


def test_route_heights_of_a_climb():
    """The track is the way from above."""
    goal = Goal(np.array([0.0, 1.6, 4.0]), np.array([0, 0, 1.0]))
    route = Route(np.zeros(3), np.array([[0, 0, 0], [0, 0, 1], [0, 1, 3.0]]), goal, "sit")
    track = np.stack([np.zeros(41), np.linspace(0, 4, 41)], -1)
    heights = route.heights(track, track[:, 1])
    assert np.allclose(heights, np.clip((track[:, 1] - 1) / 2, 0, 1), atol=0.05)
    assert route.goals[-1][1] == pytest.approx(0.6)


WAYS = (
    (np.array([[0, 0, 0], [0, 0, 4.0], [3.0, 0, 4.0]]), [0.3, 1.0], 0.5, 1.0),
    (np.array([[0, 0, 0], [0, 0, 4.0], [3.0, 0, 4.0]]), [1.0, 4.2], 3.5, 4.5),  # at most a metre ahead
    (np.array([[0, 0, 0], [0, 0, 4.0], [3.0, 0, 4.0]]), [0.0, 1.0], 2.0, 2.0),  # never backwards
    (np.array([[0, 0, 0], [2.0, 0, 0], [2.0, 0, 2.0], [1.0, 0, 2.0], [1.0, 0, -2.0]]), [1.0, 0.1], 0.6, 1.0),
    (np.array([[0, 0, 0], [2.0, 0, 0], [2.0, 0, 2.0], [1.0, 0, 2.0], [1.0, 0, -2.0]]), [1.0, 0.1], 6.5, 6.9),
)


def test_a_batch_of_routes_equals_single_routes():
    """The closest point on the route ahead of a known place, also where the route crosses itself."""
    routes = [Route(way[0], way, Goal(way[-1], np.array([0, 0, 1.0]), "walk"), "walk") for way, *_ in WAYS]
    places = np.array([place for _, place, _, _ in WAYS])
    behind = np.array([was for _, _, was, _ in WAYS])
    together = Routes(routes).project(places, behind)
    np.testing.assert_allclose(together, [found for *_, found in WAYS], atol=1e-9)
    for k, route in enumerate(routes):
        assert Routes([route]).project(places[k : k + 1], behind[k : k + 1])[0] == pytest.approx(together[k])
        along = np.linspace(-1, 9, 7)[None]
        np.testing.assert_allclose(Routes(routes).at(np.tile(along, (5, 1)))[k], Routes([route]).at(along)[0])


@pytest.mark.parametrize("rise, hang", [(0.3, True), (0.0, False)])
def test_feet_that_are_said_to_stand_do_not_pull_the_pelvis_into_a_high_seat(rise, hang):
    # The pelvis of `glide` ends at 0.63 m, over a seat of 0.45 m; with 0.3 m more, feet cannot reach the floor.
    motion = glide("sit")
    root = motion.root.copy()
    root[WALK:, 1] += rise * np.clip((np.arange(FRAMES - WALK)) / 20, 0, 1)
    quats = motion.rotations.copy()
    half = np.radians(-40.0)
    for hip, knee in ((1, 4), (2, 5)):
        quats[WALK:, hip] = [np.cos(half), np.sin(half), 0, 0]
        quats[WALK:, knee] = [np.cos(half), -np.sin(half), 0, 0]
    motion = replace(
        motion, root=root, rotations=quats, contacts=np.ones((FRAMES, 5)), interaction_start=None
    )
    goal = Goal(root[-1], np.array([0.0, 0.0, 1.0]), "sit")
    route = Route(np.zeros(3), np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 2.4]]), goal, "sit")
    finished = finish.finish(motion, route, root[:, 2], "sit", without=("smoothing",))
    assert finished.root[-1, 1] == pytest.approx(root[-1, 1], abs=0.01)
    feet = finished.contacts[-1, 3:]
    assert (feet == 0).all() if hang else (feet == 1).all()


@pytest.mark.parametrize("pelvis, raised", [(0.92, True), (0.62, False)])
def test_thighs_lie_on_a_high_seat(pelvis, raised):
    # Thighs that slope down by 40 degrees, on a seat that reaches 35 cm ahead.
    motion = glide("sit")
    half = np.radians(-50.0) / 2
    quats = motion.rotations.copy()
    for hip, knee in ((1, 4), (2, 5)):
        quats[:, hip] = [np.cos(half), np.sin(half), 0, 0]
        quats[:, knee] = [np.cos(half), -np.sin(half), 0, 0]
    motion = replace(motion, root=np.tile([0.0, pelvis, 0.0], (FRAMES, 1)), rotations=quats)
    points, _ = sample_surface(box((-0.25, 0.0, -0.2), (0.25, pelvis - 0.18, 0.35)), 30000, seed=0)
    top = RestingTop.of(points, Goal(motion.root[-1], np.array([0.0, 0.0, 1.0]), "sit"), 0.0)
    seated = np.arange(FRAMES) > WALK
    after = high_seat.with_level_thighs(motion, top, seated)
    old, new = motion.forward_kinematics(), after.forward_kinematics()
    assert (new[0][-1, 4, 1] - old[0][-1, 4, 1] > 0.05) == raised
    assert np.allclose(old[0][:50], new[0][:50])
    assert np.abs((old[1][:, 4] * new[1][:, 4]).sum(-1)) == pytest.approx(1, abs=1e-6)
