"""Episodes: walks follow their routes, pieces join without jumps, other bodies stand on the floor and on seats."""

import numpy as np
import pytest
from room_clips import small_bank
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.training.rooms.episodes import bank as banks
from samp_blender.training.rooms.episodes import blending, bodies, captured, generation, matching, route
from samp_blender.training.rooms.episodes.scene import Scene
from samp_blender.training.rooms.episodes.search import Search

SIT = banks.LABELS.index("sit")


@pytest.fixture(scope="module")
def frames():
    return small_bank()


def walked(frames, routes, starts):
    idle = np.flatnonzero((frames.labels == banks.LABELS.index("idle")) & (frames.still > 20))[0]
    pose = np.repeat(frames.pose[idle][None], len(routes), axis=0)
    return matching.walk(
        Search(frames), routes, np.array(starts), pose, np.zeros(len(routes)), np.random.default_rng(0)
    )


def test_a_route_keeps_its_ends_and_rounds_its_corners():
    corners = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0]])
    made = route.rounded(corners, 0.0, 1.0)
    np.testing.assert_allclose(made.points[[0, -1]], corners[[0, -1]], atol=1e-6)
    assert 0.02 < np.linalg.norm(made.points - corners[1], axis=-1).min() < 0.25
    assert np.abs(np.diff(made.tangent)).max() < 0.3
    np.testing.assert_allclose(np.linalg.norm(np.diff(made.points, axis=0), axis=-1), route.STEP, atol=0.003)


@pytest.mark.parametrize(
    "corners", [[[0, 0], [0, 3]], [[0, 0], [0, 2], [2, 2.5]], [[1, 1], [1, 2.5], [0.0, 4.0]]]
)
def test_walks_follow_their_route_and_arrive(frames, corners):
    corners = np.array(corners, float)
    end = np.arctan2(*(corners[-1] - corners[-2]))
    made = route.rounded(corners, end, 0.9)
    (walk,) = walked(frames, [made], [[*corners[0], 0.0]])
    assert walk.arrived and len(walk.flat) == sum(count for _, count in walk.runs)
    off = np.linalg.norm(walk.flat[:, None, :2] - made.points, axis=-1).min(1)
    assert off.max() < 0.3
    assert np.linalg.norm(np.diff(walk.flat[:, :2], axis=0), axis=-1).max() < 0.08


def test_pieces_join_without_jumps(frames):
    first, second = 40, 560
    a = blending.from_bank(frames, first, frames.flat[first : first + 60])
    place = banks.turned_flat(frames.flat[second : second + 60], frames.flat[first + 59])
    bent = blending.from_bank(frames, second, place)
    bent.rotations[:, skeleton.INDEX["left_elbow"]] = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]))
    whole = blending.joined([a, bent])
    elbow = skeleton.INDEX["left_elbow"]
    turn = rotation.multiply(whole.rotations[1:, elbow], rotation.conjugate(whole.rotations[:-1, elbow]))
    assert np.linalg.norm(rotation.to_axis_angle(turn), axis=-1).max() < 0.15
    np.testing.assert_allclose(
        np.abs(whole.rotations[-1, elbow]), np.abs(bent.rotations[-1, elbow]), atol=0.02
    )
    assert len(whole) == 120 and np.linalg.norm(np.diff(whole.root, axis=0), axis=-1).max() < 0.08


@pytest.mark.parametrize("name, value", [("tall", 0.5), ("short", 0.5), ("heavy", 0.45)])
def test_other_bodies_keep_their_feet_on_the_floor_and_their_seat(frames, name, value):
    shape = np.array([value if s == name else 0.0 for s in bodies.SHAPES])
    build = bodies.of(shape)
    piece = blending.from_bank(frames, 40, frames.flat[40:100])
    stand = blending.Piece(
        piece.root[blending.LEAD :], piece.rotations[blending.LEAD :], piece.labels, piece.feet, piece.source,
        piece.hands, piece.object,
    )  # fmt: skip
    carried = bodies.carried(stand, build)
    joints, _ = skeleton.forward_kinematics(carried.root, carried.rotations, build.body.joints)
    ankle = skeleton.INDEX["left_ankle"]
    over = build.body.joints[ankle, 1] - build.body.floor
    before, _ = skeleton.forward_kinematics(stand.root, stand.rotations, skeleton.default_rest_joints())
    assert np.abs(joints[:, ankle, [0, 2]] - before[:, ankle, [0, 2]]).max() < 0.03
    default = bodies.of(np.zeros(8)).body
    lift = over - (default.joints[ankle, 1] - default.floor)
    np.testing.assert_allclose(joints[:, ankle, 1], before[:, ankle, 1] + lift, atol=0.02)
    seated = blending.Piece(**{**vars(stand), "labels": np.full(len(stand), SIT)})
    rise = bodies.carried(seated, build).root[:, 1] - seated.root[:, 1]
    np.testing.assert_allclose(rise, build.seat, atol=1e-6)
    assert abs(build.seat) < 0.08


@pytest.mark.parametrize("bad, span", [
    ([], (0, 1000)), ([0], (4, 1000)), ([500], (0, 497)), ([450], (454, 1000)), ([200, 210, 990], (214, 987)),
    ([440, 880], None),
])  # fmt: skip
def test_the_longest_span_away_from_bad_frames_is_kept(bad, span):
    found = generation._longest_clean(np.array(bad, int), 1000)
    assert found == span


def test_deviation_is_that_of_the_most_different_joint(frames):
    rotations = frames.rotations[40:44].astype(np.float64)
    turn = rotation.from_axis_angle(np.radians([0.0, 0.0, 7.5]))
    knee, wrist = skeleton.INDEX["left_knee"], skeleton.INDEX["left_wrist"]
    rotations[1, knee] = rotation.multiply(turn, rotations[1, knee])
    rotations[2, wrist] = rotation.multiply(turn, rotations[2, wrist])
    found = captured.deviation(frames, rotations, np.array([40, 41, 42, -1]))
    assert found[0] <= 1 and found[1] == 8 and found[2] <= 1 and found[3] == captured.UNKNOWN


@pytest.mark.parametrize(
    "free, reachable", [(np.zeros((0, 3)), False), ([[1.0, 0.0, 2.3]], True), ([[1.0, 0.0, 3.0]], False)]
)
def test_a_place_is_reachable_from_free_floor_near_it(free, reachable):
    """A room that is full of furniture has no free floor at all."""
    scene = Scene.__new__(Scene)
    scene.free = np.array(free)
    assert scene.reachable(np.array([1.0, 2.0])) == reachable
