"""Goals by geometry: on seats and mattresses, facing the free side."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
from samp_blender.samp_addon import frames
from samp_blender.samp_addon.errors import SampError
from samp_blender.samp_addon.motion import Goal
from samp_blender.samp_addon.scene.seats import front, postures, seats
from samp_blender.training import furniture
from samp_blender.training.furniture import shapes

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data" / "furniture"


def chair(seat=0.45, arms=False):
    parts = [
        shapes.box((-0.22, seat - 0.04, -0.22), (0.22, seat, 0.22)),
        shapes.box((-0.22, seat, -0.25), (0.22, seat + 0.45, -0.22)),
    ]
    parts += [
        shapes.box((x - 0.02, 0, z - 0.02), (x + 0.02, seat, z + 0.02))
        for x in (-0.2, 0.2)
        for z in (-0.2, 0.2)
    ]
    if arms:
        parts += [
            shapes.box((s * 0.26 - 0.04, 0, -0.22), (s * 0.26 + 0.04, seat + 0.2, 0.22)) for s in (-1, 1)
        ]
    return shapes.join(parts)


def slab(width, height, depth):
    return shapes.box((-width / 2, 0, -depth / 2), (width / 2, height, depth / 2), 4)


def sofa(inner, pad=0.42):
    x = inner / 2
    return shapes.join(
        [
            shapes.box((-x, 0, -0.3), (x, pad, 0.3), 4),
            shapes.box((-x, 0, -0.5), (x, 0.85, -0.3), 4),
            shapes.box((-x - 0.2, 0, -0.5), (-x, 0.62, 0.3), 4),
            shapes.box((x, 0, -0.5), (x + 0.2, 0.62, 0.3), 4),
        ]
    )


def placed(triangles, yaw=0.0, offset=(0.0, 0.0, 0.0)):
    return shapes.turned(triangles, yaw) + np.asarray(offset)


def yaw_gap(a, b):
    return abs((a - b + np.pi) % (2 * np.pi) - np.pi)


@pytest.mark.parametrize("yaw", [0.0, 0.4, 1.9, -2.6])
@pytest.mark.parametrize("offset", [(0, 0, 0), (3.0, 2.5, -4.0)])
def test_the_best_goal_on_a_chair_is_central_and_faces_away_from_the_back(yaw, offset):
    goal = seats.find_goals(placed(chair(), yaw, offset), "sit")[0]
    assert yaw_gap(frames.direction_yaw(goal.direction), yaw) < np.radians(6)
    local = shapes.turned((goal.position - offset)[None, None], -yaw)[0, 0]
    assert abs(local[0]) < 0.04 and -0.14 < local[2] < 0.04
    assert local[1] == pytest.approx(0.45 + postures.SEAT_TO_PELVIS, abs=0.01)


def test_only_chairs_without_arms_have_sideways_goals():
    yaws = lambda piece: [frames.direction_yaw(g.direction) for g in seats.find_goals(piece, "sit")]
    sideways = lambda piece: [y for y in yaws(piece) if abs(abs(y) - np.pi / 2) < 0.3]
    assert len(sideways(chair())) == 2
    assert not sideways(chair(arms=True)) and yaws(chair(arms=True))
    assert not [y for y in yaws(chair()) if abs(y) > 2.0], "no goal faces the backrest"


@pytest.mark.parametrize(
    "triangles",
    [slab(0.4, 0.12, 0.4), slab(0.5, 1.1, 0.5), slab(0.12, 0.45, 1.0), slab(0.2, 0.45, 0.2)],
    ids=["too low", "too high", "too narrow", "too small"],
)
def test_unsuitable_objects_have_no_goals(triangles):
    assert seats.find_goals(triangles, "sit") == []


def test_a_sofa_has_several_goals_on_its_seat():
    found = seats.find_goals(sofa(1.9), "sit")
    assert len(found) >= 3
    for goal in found:
        x, y, z = goal.position
        assert (
            abs(x) < 0.95 and -0.3 < z < 0.3 and y == pytest.approx(0.42 + postures.SEAT_TO_PELVIS, abs=0.02)
        )
    xs = sorted(goal.position[0] for goal in found if goal.direction[2] > 0.9)
    assert np.ptp(xs) > 1.0 and np.diff(xs).min() > 0.25


def test_goals_on_a_hollow_bed_are_at_its_edge():
    sheet = np.array(
        [[[-0.8, 0.5, -1], [-0.8, 0.5, 1], [0.8, 0.5, 1]], [[-0.8, 0.5, -1], [0.8, 0.5, 1], [0.8, 0.5, -1]]]
    )
    found = seats.find_goals(sheet, "sit", floor_height=0.0)
    assert len(found) > 4
    for goal in found:
        knees = goal.position + 0.45 * goal.direction
        assert abs(knees[0]) > 0.78 or abs(knees[2]) > 0.98


def test_boards_and_rails_obstruct_a_seat():
    seat = slab(0.5, 0.45, 0.5)
    board = shapes.box((-0.5, 0.8, -0.5), (0.5, 0.83, 0.5), 4)
    assert seats.find_goals(seat, "sit")
    assert not seats.find_goals(shapes.join([seat, board + [0, 0.0, 0]]), "sit", floor_height=0.0) or all(
        goal.position[1] > 0.9 for goal in seats.find_goals(shapes.join([seat, board]), "sit")
    )
    rails = [shapes.turned(shapes.box((-0.3, 0, 0.27), (0.3, 1.0, 0.30), 6), k * np.pi / 2) for k in range(4)]
    assert not seats.find_goals(shapes.join([seat, *rails]), "sit")


def test_obstacles_block_the_side_they_are_on():
    stool, wall = slab(0.4, 0.45, 0.4), shapes.box((-2, 0, 0.3), (2, 2.4, 0.4), 8)
    free = [g.direction for g in seats.find_goals(stool, "sit")]
    closed = [g.direction for g in seats.find_goals(stool, "sit", obstacles=wall)]
    assert any(d[2] > 0.9 for d in free)
    assert closed and not any(d[2] > 0.5 for d in closed)


def test_goals_do_not_depend_on_winding_and_yaw():
    base = seats.find_goals(chair(), "sit")
    flipped = seats.find_goals(chair()[:, ::-1], "sit")
    np.testing.assert_allclose([g.position for g in base], [g.position for g in flipped], atol=1e-9)
    for yaw in np.random.default_rng(0).uniform(-np.pi, np.pi, 4):
        turned = seats.find_goals(placed(chair(), yaw), "sit")
        assert len(turned) == len(base)


def test_lie_goals_have_the_head_at_the_raised_end():
    bed = shapes.join([slab(0.95, 0.45, 2.05), shapes.box((-0.48, 0, -1.08), (0.48, 1.0, -1.02), 4)])
    goal = seats.find_goals(bed, "lie")[0]
    assert goal.direction[2] > 0.97
    assert goal.position[1] == pytest.approx(0.45 + postures.BED_TO_PELVIS, abs=0.02)
    assert abs(goal.position[0]) < 0.2 and abs(goal.position[2]) < 0.3


@pytest.mark.parametrize(
    ("triangles", "lies"),
    [(sofa(1.95), True), (sofa(0.9), False), (slab(0.5, 0.45, 0.5), False), (slab(0.7, 0.4, 1.8), True)],
    ids=["long sofa", "love seat", "stool", "day bed"],
)
def test_lying_needs_a_body_length(triangles, lies):
    assert bool(seats.find_goals(triangles, "lie")) == lies


def test_the_lying_direction_is_the_heading_of_a_body_on_its_back():
    # Standing, the left hip is at +X when facing +Z. Tipped onto the back, up turns to -Z: the head lies at -Z.
    left_to_right = np.array([1.0, 0, 0])
    heading = np.cross(left_to_right, [0, 1.0, 0])
    head_to_feet = -np.array([0, 0, -1.0])
    np.testing.assert_allclose(heading, head_to_feet)


def test_snapping_keeps_good_goals_lifts_low_ones_and_rejects_others():
    best = seats.find_goals(sofa(1.9), "sit")[0]
    kept = seats.snap_goal(sofa(1.9), best)
    np.testing.assert_allclose(kept.position, best.position, atol=0.01)
    sunk = Goal(best.position - [0, 0.3, 0], best.direction, "sit")
    np.testing.assert_allclose(seats.snap_goal(sofa(1.9), sunk).position, best.position, atol=0.01)
    aside = Goal(best.position + [0, 0, 1.5], best.direction, "sit")
    assert seats.snap_goal(sofa(1.9), aside) is None
    backwards = Goal(best.position, -best.direction, "sit")
    assert seats.snap_goal(sofa(1.9), backwards) is None


@pytest.mark.parametrize(
    "triangles",
    [np.zeros((0, 3, 3)), np.zeros((3, 3, 3)), np.full((2, 3, 3), np.nan)],
    ids=["empty", "no area", "not numbers"],
)
def test_objects_without_a_surface_raise_an_error(triangles):
    with pytest.raises(SampError, match="object"):
        seats.find_goals(triangles, "sit")


@pytest.mark.parametrize("category", ["chair", "armchair", "sofa", "office_chair"])
def test_the_front_of_procedural_furniture_is_found_at_any_yaw(category):
    rng = np.random.default_rng(2)
    misses = 0
    for _ in range(12):
        yaw = rng.uniform(-np.pi, np.pi)
        piece = placed(furniture.generate(category, rng).triangles, yaw, rng.uniform(-3, 3, 3))
        misses += yaw_gap(seats.infer_front_yaw(piece), yaw) > np.radians(10)
    assert misses <= 1


def test_the_axis_of_a_sheet_without_upright_faces_comes_from_its_outline():
    sheet = np.array([[[-1, 0, -0.5], [-1, 0, 0.5], [1, 0, 0.5]], [[-1, 0, -0.5], [1, 0, 0.5], [1, 0, -0.5]]])
    assert front.dominant_axis(placed(sheet, 0.5)) == pytest.approx(0.5, abs=0.02)


@pytest.mark.skipif(not SHARED.exists(), reason="the furniture library is not available")
def test_goals_on_real_furniture_face_its_front():
    pieces = [
        p for p in furniture.load(SHARED) if p.category in ("chair", "armchair", "sofa", "office_chair")
    ]
    fronts, found = [], 0
    for piece in pieces[::2]:
        goals = seats.find_goals(piece.triangles, "sit")
        found += bool(goals)
        fronts += [goals[0].direction[2] > 0.8] if goals else []
        top = piece.triangles[..., 1].max()
        assert all(goal.position[1] - postures.SEAT_TO_PELVIS < top + 0.01 for goal in goals)
    assert found == len(pieces[::2])
    assert np.mean(fronts) > 0.9


def test_a_hundred_thousand_triangles_take_less_than_a_second():
    piece = sofa(1.9)
    while len(piece) < 100_000:
        middle = (piece + np.roll(piece, -1, axis=1)) / 2
        corner = [np.stack([piece[:, k], middle[:, k], middle[:, k - 1]], 1) for k in range(3)]
        piece = np.concatenate([*corner, middle])
    seats.find_goals(piece[:1000], "sit")
    begun = time.process_time()
    assert seats.find_goals(piece, "sit")
    # 0.2 s on an idle core; the bound leaves room for a busy machine.
    assert time.process_time() - begun < 1.0
