"""Long-term: contacts, feet on the floor while a body sits down, pelvis and pace over a seat, floors with a step."""

from dataclasses import replace

import numpy as np
import pytest
import rooms
from samp_blender.samp_addon import rotation
from samp_blender.samp_addon.body import hand_poses
from samp_blender.samp_addon.methods.long_term import joining, planning, resting
from samp_blender.samp_addon.methods.long_term.figure import Figure, as_motion
from samp_blender.samp_addon.methods.long_term.sub_goals.places import Place
from samp_blender.samp_addon.methods.long_term.surfaces import Surfaces
from samp_blender.samp_addon.methods.long_term.synthesis import Synthesis
from samp_blender.samp_addon.refine.feet.foot import FEET
from samp_blender.samp_addon.refine.feet.grounding import sole_heights
from samp_blender.samp_addon.scene.navmesh import navmesh
from samp_blender.samp_addon.skeleton import INDEX
from samp_blender.samp_addon.vocabulary import ACTIONS

STANDS, SITS = 0.93, 0.5
FRAMES = 60
STEPPED = [((-3, -0.1, -3), (3, 0, 3)), ((0, 0, -3), (3, 0.16, 3))]
"""A floor with a step of 16 cm."""


def moving(root):
    """Return a body of straight legs whose pelvis moves along (T, 3)."""
    quats = np.zeros((22, 4))
    quats[:, 0] = 1
    body = Figure(np.array([0.0, STANDS, 0.0]), quats, hand_poses.code("relaxed"), np.zeros(10))
    return replace(as_motion([body] * len(root)), root=np.array(root))


def acting(motion, name, weight=1.0):
    """Return a motion with one action, of a weight (T,) or one number, idle besides."""
    actions = np.zeros((len(motion), len(ACTIONS)))
    actions[:, ACTIONS.index(name)] = weight
    actions[:, ACTIONS.index("idle")] += 1 - actions.sum(1)
    return replace(motion, actions=actions)


def descent():
    """Return the way of a pelvis that sinks in a straight line from half a metre in front of its seat."""
    share = np.linspace(0, 1, FRAMES)
    return np.column_stack([0 * share, STANDS + share * (SITS - STANDS), 0.6 * (1 - share)])


def sinking(seconds, rises=False):
    """Return a body of straight legs whose pelvis sinks straight to its seat, or rises from it, in some seconds."""
    share = np.linspace(0, 1, round(30 * seconds) + 1)
    root = np.column_stack([0 * share, STANDS + share * (SITS - STANDS), 0 * share])
    return moving(root[::-1] if rises else root)


def test_contacts_of_standing_and_lifted_feet():
    root, floor = np.tile([0.0, STANDS, 0.0], (40, 1)), np.zeros(40)
    still = acting(moving(root), "idle")
    found = joining.contacts(still, floor)
    assert found[:, 3:].all() and not found[:, 0].any()
    moved = lambda metres: root + np.linspace(0, 1, 40)[:, None] * [0.0, 0.0, metres]
    glides = joining.contacts(replace(still, root=moved(1.5)), floor)[:, 3:]
    assert (glides.sum(1) == 1).all()  # a foot carries a body that does not run
    assert not joining.contacts(replace(still, root=moved(4.0)), floor)[:, 3:].any()
    for height, stands in ((0.0, True), (0.3, False)):  # the feet of a seated body may hang
        seated = acting(moving(root + [0.0, height, 0.0]), "sit")
        assert joining.contacts(seated, floor)[:, 3:].all() == stands


def stepping_down(height, frames=40):
    """Return a standing body that sinks by a height in a third of a second, and the floor (T,) under its pelvis."""
    floor = np.interp(np.arange(frames), [15, 25], [height, 0.0])
    return acting(moving(np.outer(floor + STANDS, [0.0, 1.0, 0.0])), "idle"), floor


def test_a_foot_stays_on_what_it_stands_on_while_the_body_steps_down():
    motion, floor = stepping_down(0.16)
    assert joining.contacts(motion, floor)[:, 3:].all()
    under = np.tile([0.16, 0.0], (len(motion), 1))  # the right foot on the mattress, the left one beside it
    under[20, 0] = 0.0  # it slides over the edge
    made = sole_heights(joining.finished(motion, floor, under))
    assert np.ptp(made[:, 0]) < 0.02 and made[:, 0].mean() == pytest.approx(0.16, abs=0.02)
    np.testing.assert_allclose(made[25:, 1], 0.0, atol=0.02)


def test_feet_stay_on_the_floor_while_a_body_sits_down():
    motion = acting(moving(descent()), "sit", np.linspace(0, 1, FRAMES))
    assert sole_heights(motion).min() < -0.3
    made = joining.finished(motion, np.zeros(FRAMES), np.zeros((FRAMES, 2)))
    assert sole_heights(made).min() > -0.01
    np.testing.assert_allclose(made.root[-1], motion.root[-1], atol=0.01)
    fall = lambda one: np.diff(one.root[:, 1]).min()
    assert fall(made) > 1.6 * fall(motion)  # the body is not raised to the floor first and dropped afterwards


@pytest.mark.parametrize(
    ("sits", "low"),
    [((False, True), 0.25), ((True, False), 0.25), ((True, True), None), ((False, False), None)],
)
def test_a_pelvis_is_low_only_over_its_seat(sits, low):
    places = descent() if sits[1] else descent()[::-1]
    made = resting.raised(places, sits)
    assert made[[0, -1]].tolist() == places[[0, -1], 1].tolist()
    if low is None:
        assert made.tolist() == places[:, 1].tolist()
        return
    half = (STANDS + SITS) / 2
    assert np.abs(places[places[:, 1] < half, 2]).max() > low > np.abs(places[made < half, 2]).max()


@pytest.mark.parametrize(
    ("begin", "end"), [("walk", "sit"), ("sit", "walk"), ("walk", "idle"), ("sit", "sit")]
)
def test_feet_stand_in_front_of_the_seat_before_the_body_sits(begin, end):
    root = descent() if end == "sit" else descent()[::-1]
    motion = moving(root + 0.3 * (root[:, 2:] / 0.6) * [0.0, 0.0, 1.0])
    made = resting.planted(motion, begin, end)
    np.testing.assert_allclose(made.root, motion.root)
    if "sit" not in (begin, end) or begin == end:
        assert made.rotations.tolist() == motion.rotations.tolist()
        return
    if begin == "sit":
        made, motion = resting.backwards(made), resting.backwards(motion)
    ball = lambda one: one.forward_kinematics()[0][:, [foot.ball for foot in FEET], 2]
    away = motion.root[:, 2]
    before = np.abs(ball(motion) - ball(motion)[-1])[away < 0.4].max()
    after = np.abs(ball(made) - ball(made)[-1])[away < 0.4].max()
    assert before > 0.35 and after < 0.1
    np.testing.assert_allclose(ball(made)[0], ball(motion)[0], atol=1e-6)
    late = [np.flatnonzero(np.abs(way - way[-1]) > 0.1)[-1] for way in ball(made).T]
    assert abs(late[0] - late[1]) >= 2  # one foot after the other


def risen(hangs):
    """Return the way (T,) of a pelvis to a seat from which feet hang, and by how much both balls rise (T, 2) on it."""
    root = descent() * [1.0, 0.0, 1.0] + [0.0, STANDS, 0.0]
    root[:, 1] += np.interp(root[:, 2], [0.0, 0.05], [hangs, 0.0])  # the whole body is higher in the end
    motion = moving(root)
    ball = lambda one: one.forward_kinematics()[0][:, [foot.ball for foot in FEET], 1]
    return root[:, 2], ball(resting.planted(motion, "walk", "sit")) - ball(motion)


def test_feet_that_hang_from_a_high_seat_rise_before_the_thighs_are_over_it():
    away, high = risen(0.2)
    _, low = risen(0.05)
    more = high - low
    assert (more[(away > 0.06) & (away < 0.2)] > 0.1).all() and np.abs(more[away > 0.5]).max() < 0.01
    np.testing.assert_allclose(high[[0, -1]], 0.0, atol=1e-6)


def test_a_resting_body_hardly_moves_what_lies_on_its_seat():
    motion = moving(np.linspace([0, SITS, 0], [0, SITS - 0.08, 0.04], FRAMES))
    rotations = motion.rotations.copy()
    rotations[:, [INDEX["left_hip"], INDEX["neck"]]] = rotation.from_axis_angle(
        np.linspace([0.0, 0, 0], [0.8, 0, 0], FRAMES)
    )[:, None]
    made = resting.stilled(replace(motion, rotations=rotations))
    assert np.abs(made.root - motion.root[0]).max() == pytest.approx(0.25 * 0.08)
    turned = lambda joint: np.linalg.norm(rotation.to_axis_angle(made.rotations[-1, INDEX[joint]]))
    assert turned("left_hip") == pytest.approx(0.2, abs=1e-6) and turned("neck") == pytest.approx(
        0.8, abs=1e-6
    )


@pytest.mark.parametrize(
    ("begin", "end", "seconds", "slower"),
    [
        ("walk", "sit", 0.5, True),
        ("sit", "walk", 0.5, True),
        ("walk", "idle", 0.5, False),
        ("walk", "sit", 3, False),
    ],
)
def test_the_pace_over_a_seat(begin, end, seconds, slower):
    motion = sinking(seconds, rises=end != "sit")
    made = resting.paced(motion, begin, end)
    np.testing.assert_allclose(made.root[[0, -1]], motion.root[[0, -1]], atol=1e-9)
    assert (len(made) > len(motion)) == slower
    over = (made.root[:, 1] - SITS) / (STANDS - SITS)
    speed = np.linalg.norm(np.gradient(made.root, 1 / 30, axis=0), axis=-1)
    if slower:
        assert speed[over < 0.5].max() < 1.1 * resting.FASTEST["sit"]


@pytest.mark.parametrize(
    ("begin", "end", "seconds", "faster"),
    [
        ("walk", "sit", 2, True),
        ("sit", "walk", 2, True),
        ("walk", "sit", 0.5, False),
        ("walk", "lie", 2, False),
        ("sit", "sit", 2, False),
    ],
)
def test_a_body_does_not_squat_for_long(begin, end, seconds, faster):
    motion = sinking(seconds, rises=begin == "sit")
    made = resting.hastened(motion, begin, end)
    np.testing.assert_allclose(made.root[[0, -1]], motion.root[[0, -1]], atol=1e-9)
    between = lambda one: ((one.root[:, 1] > SITS + 0.12) & (one.root[:, 1] < STANDS - 0.12)).sum()
    if faster:
        assert between(made) <= resting.LONGEST < between(motion)
    else:
        assert len(made) == len(motion)


def test_nobody_goes_from_seat_to_seat_without_rising():
    mesh = navmesh.build(rooms.box(*STEPPED[0]))
    line = np.array([[0.0, 0, 0], [0.0, 0, 0.4], [0.9, 0, 0.4], [0.9, 0, 0.0]])
    place = lambda action, at: Place(action, np.array(at) + [0.0, 0.5, 0.0], 0.0, np.array(at))
    *between, end = planning.divided(mesh, line, place("sit", line[0]), place("sit", line[-1])).stops
    assert end.action == "sit" and {stop.action for stop in between} == {"walk"}
    assert all(stop.floor[2] == pytest.approx(0.4) for stop in between)
    whole = planning.divided(mesh, line, place("idle", line[0]), place("idle", line[-1]))
    assert len(whole.stops) == 1


@pytest.mark.parametrize(("first", "level"), [(-2.6, 0.0), (-1.2, 0.16)])
def test_places_between_are_on_the_ground_before_and_behind_a_step(first, level):
    mesh = navmesh.build(np.concatenate([rooms.box(*box) for box in STEPPED]))
    floors = np.array([[first, 0.0, 0.0], [first + 3.2, 0.16, 0.0]])
    stops = [Place("idle", floor + [0.0, STANDS, 0.0], np.pi / 2, floor) for floor in floors]
    ((between, _),) = (leg.stops for leg in planning.legs(mesh, stops, np.random.default_rng(0), 0.0))
    assert between.floor[1] == pytest.approx(level, abs=0.02)


def test_the_floor_over_a_step_is_where_it_is():
    triangles = np.concatenate([rooms.box(*box) for box in STEPPED])
    surfaces = Surfaces(triangles, navmesh.build(triangles))
    places = np.column_stack([np.linspace(-1, 1, 61), np.full(61, STANDS), np.zeros(61)])
    floors = surfaces.floors(places, 0.0, 0.16)
    np.testing.assert_allclose(floors[:20], 0.0, atol=0.02)
    np.testing.assert_allclose(floors[-20:], 0.16, atol=0.02)
    motion = moving(places)
    floors = Synthesis(None, surfaces, None, 0.0, 1.0, 0.0, 0.0).floors(motion, 0.0, 0.16)
    assert floors.shape == (61, 3)
    joints = motion.forward_kinematics()[0]
    for column, foot in enumerate(FEET, start=1):  # each foot has passed the edge when it is over the step
        over = joints[:, foot.ball, 0]
        np.testing.assert_allclose(floors[over < -0.2, column], 0.0, atol=0.02)
        np.testing.assert_allclose(floors[over > 0.2, column], 0.16, atol=0.02)
    assert surfaces.floors(places, 0.0, 0.01).tolist() == np.linspace(0.0, 0.01, 61).tolist()
