"""Sits fitted to the furniture in the training data: surfaces, depth both ways, the hold, and its spreading."""

import numpy as np
import pytest
from samp_blender.samp_addon import rotation, skeleton
from samp_blender.samp_addon.motion import Goal
from samp_blender.samp_addon.scene.geometry import sample_surface
from samp_blender.samp_addon.scene.seats.postures import SEAT_TO_PELVIS
from samp_blender.training.composition.sequence import Sequence
from samp_blender.training.composition.stitch import WalkIndex
from samp_blender.training.fitting import hold, make, measure, provenance, sit_fit, spreading
from samp_blender.training.fitting.lying.lie_fit import Mattress
from samp_blender.training.fitting.shapes import posing, probes, surfaces
from samp_blender.training.fitting.shapes.depth import PieceField
from samp_blender.training.fitting.shapes.pieces import FittingPiece
from samp_blender.training.fitting.sits import FittedComposer
from samp_blender.training.mocap.clip_files import Clip
from samp_blender.training.mocap.events import SitEvent
from shapes import box

LEVEL = 0.45
SEAT = box((-0.25, LEVEL - 0.04, -0.22), (0.25, LEVEL, 0.22))
BACK = box((-0.22, LEVEL, -0.26), (0.22, LEVEL + 0.5, -0.22))
CHAIR = np.concatenate([SEAT, BACK])
GOAL = Goal(np.array([0.0, LEVEL + SEAT_TO_PELVIS, 0.0]), np.array([0.0, 0.0, 1.0]), "sit")
SITTING = (("left_hip", -88), ("right_hip", -88), ("left_knee", 88), ("right_knee", 88))
COUNT = 90


def surface(triangles, goal=GOAL):
    return surfaces.SeatSurface.of(sample_surface(triangles, 60_000, seed=0)[0], goal)


def pose(joints=SITTING):
    quats = np.zeros((22, 4))
    quats[:, 0] = 1
    for joint, degrees in joints:
        quats[skeleton.INDEX[joint]] = rotation.from_axis_angle(np.radians([degrees, 0.0, 0.0]))
    return quats


def sitting_down():
    """A body that stands, sinks and moves back within a second over feet that stay, and stays: (clip, phases)."""
    share = np.clip((np.arange(COUNT) - 30) / 20, 0, 1)[:, None]
    root = np.array([0.0, 0.90, 0.30]) * (1 - share) + np.array([0.0, LEVEL + 0.18, 0.0]) * share
    identity = np.tile([1.0, 0, 0, 0], (COUNT, 22, 1))
    quats = rotation.slerp(identity, np.broadcast_to(pose(), identity.shape), share)
    flat = np.broadcast_to([1.0, 0.0, 0.0, 0.0], (COUNT, 4))
    places = {side: np.tile([x, 0.08, 0.36], (COUNT, 1)) for side, x in (("left", 0.1), ("right", -0.1))}
    quats = posing.planted(root, quats, places, {"left": flat, "right": flat})
    labels = np.array(["idle"] * 30 + ["sit_down"] * 20 + ["sit"] * 40)
    clip = Clip("made", root, quats, labels, np.ones((COUNT, 2)), np.zeros(COUNT, bool))
    return clip, spreading.Phases(30, 50, COUNT - 1, COUNT - 1)


@pytest.mark.parametrize("triangles, backed", [(SEAT, False), (CHAIR, True)])
def test_a_seat_tells_its_ends_and_its_back(triangles, backed):
    found = surface(triangles)
    assert found.level == pytest.approx(LEVEL)
    assert found.edge == pytest.approx(0.22, abs=0.03)
    assert found.rear == pytest.approx(-0.22, abs=0.03)
    assert found.backed is backed
    if backed:
        assert found.rest == pytest.approx(-0.22, abs=0.01)


def test_a_seat_frame_and_its_piece_are_one_place():
    frame = surfaces.Frame.of(Goal(np.array([0.4, 0.6, -0.3]), np.array([1.0, 0.0, 0.0]), "sit"))
    points = np.random.default_rng(0).normal(size=(5, 3))
    np.testing.assert_allclose(frame.to_piece(frame.to_seat(points)), points, atol=1e-12)
    x, z, yaw = frame.placement
    there = rotation.rotate(np.broadcast_to(rotation.about_y(yaw), (5, 4)), points) + [x, 0.0, z]
    np.testing.assert_allclose(there, frame.to_seat(points), atol=1e-12)


@pytest.mark.parametrize("height, expected", [(0.30, "free"), (0.10, "skin"), (0.0, "surface")])
def test_depth_is_seen_both_ways(height, expected):
    """A block under the pelvis: away from it, pressed into it, and a thin board through the middle of the body."""
    thick = 0.4 if expected == "skin" else 0.01
    block = box((-0.5, -height - thick, -0.5), (0.5, -height, 0.15))
    field = PieceField.of(block, 0.0)
    root, quats = np.zeros((1, 3)), pose()[None]
    skin = field.skin_depth(probes.skinned(root, quats)).max()
    under = field.surface_depth(probes.interior(root, quats), root, quats).max()
    deepest, _ = field.deepest(root, quats)
    assert deepest[0] == pytest.approx(max(skin, under))
    if expected == "free":
        assert deepest[0] < 0.005
    if expected == "skin":
        assert skin > 0.04
    if expected == "surface":
        assert skin < 0.02 < under


@pytest.mark.parametrize("mode, leans", [("leaning", True), ("upright", False)])
def test_a_hold_rests_on_its_seat_and_leans_on_its_back(mode, leans):
    found = surface(CHAIR)
    quats = pose()
    feet = posing.ankles(np.array([[0.0, LEVEL + 0.18, 0.0]]), quats[None])
    solved = hold.solve(np.array([0.0, LEVEL + 0.18, 0.0]), quats, feet, found, mode, -0.05, 0.0, 0.1 * leans)
    assert solved.pressed < 0.012
    assert (abs(solved.gap) < 0.01) is leans
    assert 0.12 < solved.height - LEVEL < 0.25


def test_a_fitted_sit_is_in_nothing_and_its_feet_stay():
    clip, phases = sitting_down()
    found, field = surface(CHAIR), PieceField.of(CHAIR, 0.0)
    made = sit_fit.fit(clip, phases, found, field, "leaning", np.random.default_rng(0))
    at, turns = sit_fit.in_piece(made.clip, found, np.arange(COUNT))
    assert field.deepest(at, turns)[0].max() <= sit_fit.DEEPEST
    assert abs(np.median(hold.back_gap(made.clip.root[60:], made.clip.rotations[60:], found))) < 0.02
    before, after = (posing.ankles(c.root, c.rotations)[0]["left"] for c in (clip, made.clip))
    moved = after - before
    np.testing.assert_allclose(moved[:25] - moved[0], 0.0, atol=2e-3)


def test_a_seat_without_room_for_the_shins_is_refused():
    clip, phases = sitting_down()
    boxed_in = np.concatenate([SEAT, box((-0.6, 0.0, 0.24), (0.6, 0.3, 1.4))])
    with pytest.raises(sit_fit.Unfit, match="shins"):
        field = PieceField.of(boxed_in, 0.0)
        sit_fit.fit(clip, phases, surface(boxed_in), field, "upright", np.random.default_rng(0))


def test_what_is_changed_is_counted():
    clip, _ = sitting_down()
    bent = posing.leant(clip.rotations, np.zeros(COUNT), np.where(np.arange(COUNT) < 45, 0.0, -0.5))
    made = Clip(clip.name, clip.root, bent, clip.labels, clip.feet, clip.bad)
    shares = provenance.total([provenance.owed(clip, made)])
    assert shares == {"legs": 1.0, "trunk": 0.5, "both": 0.5, "arms": 1.0}


def test_a_mattress_is_its_top():
    bed = np.concatenate([box((-0.7, 0.0, -1.0), (0.7, 0.5, 1.0)), box((-0.3, 0.5, -0.95), (0.3, 0.6, -0.6))])
    top = Mattress.of(sample_surface(bed, 40_000, seed=0)[0], 0.5)
    over = top.over(np.array([[0.0, 0.7, 0.3], [0.0, 0.7, -0.8], [2.0, 0.7, 0.0]]))
    np.testing.assert_allclose(over[:2], [0.2, 0.1], atol=0.015)
    assert over[2] > 1


def test_a_sequence_has_its_goal_where_the_pelvis_rests():
    clip, _ = sitting_down()
    legs = np.concatenate(
        [
            box((x - 0.02, 0, z - 0.02), (x + 0.02, LEVEL - 0.04, z + 0.02))
            for x in (-0.2, 0.2)
            for z in (-0.2, 0.2)
        ]
    )
    piece = FittingPiece(7, "chair", "made", np.concatenate([CHAIR, legs]))
    event = SitEvent(clip, 0, 30, 50, COUNT - 1, COUNT - 1, COUNT - 1, clip.root[-1], 0.0)
    walk = Clip(
        "01_01", clip.root[:31], clip.rotations[:31], np.array(["walk"] * 31), clip.feet[:31], clip.bad[:31]
    )
    composer = FittedComposer([piece], WalkIndex([walk]), seed=0)
    made = [sequence for _ in range(6) for sequence in composer.compose(event)]
    assert made, composer.report
    for sequence in made:
        assert sequence.piece == 7
        assert len(sequence) == len(sequence.goal) == len(sequence.labels)
        np.testing.assert_allclose(sequence.goal[-1, :3], np.median(sequence.root[-30:], axis=0), atol=0.02)
        surface = measure.surface_under(as_taken(sequence), piece)
        over, _ = hold.seat_gap(sequence.root[-1:], sequence.rotations[-1:], surface)
        assert abs(over[0]) < 0.01


def as_taken(sequence):
    """A sequence as measure.sequences reads it from a file."""
    return measure.Taken(
        sequence.kind, sequence.piece, np.array(sequence.placement), sequence.root, sequence.rotations,
        sequence.contacts()[:, 0], sequence.contacts()[:, 1:3], sequence.goal, sequence.goal_action,
    )  # fmt: skip


def test_pieces_that_are_sat_on_often_are_drawn_less_often():
    empty = np.zeros((1, 3)), np.zeros((1, 22, 4)), np.array(["sit"]), np.zeros((1, 2)), np.zeros(1, bool)
    on = lambda piece: Sequence("sit", *empty, np.zeros((1, 6)), np.array([3]), piece)
    weights = [s.weight for s in make.balanced([on(0), on(0), on(0), on(0), on(1)])]
    assert weights[4] == pytest.approx(2 * weights[0])
    assert np.mean(weights) == pytest.approx(1.0)
