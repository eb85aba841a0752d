"""Loungers and recliners: bodies lie with the trunk on a raised back and the legs on the level part."""

from __future__ import annotations

import numpy as np
import pytest
from samp_blender.samp_addon import frames
from samp_blender.samp_addon.scene.geometry import sample_surface
from samp_blender.samp_addon.scene.seats import reclining, seats
from samp_blender.samp_addon.scene.seats.postures import BED_TO_PELVIS
from shapes import box


def lounger(degrees, height=0.35, width=0.65, level=1.25, back=0.75, arms=0.0, yaw=0.0):
    """Return triangles of a lounger whose back begins at the origin; the feet are at +Z before the turn by yaw."""
    angle = np.radians(degrees)
    half = width / 2
    board = box((-half, -0.05, -back), (half, 0.0, 0.0))
    turn = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    parts = [box((-half, height - 0.05, 0.0), (half, height, level)), board @ turn.T + [0, height, 0]]
    parts += [
        box((x, 0, z), (x + 0.05, height - 0.05, z + 0.05))
        for x in (-half, half - 0.05)
        for z in (0, level - 0.1)
    ]
    if arms:
        parts += [box((x, 0, 0), (x + 0.1, height + arms, 0.55)) for x in (-half - 0.1, half)]
    return np.concatenate(parts) @ frames.yawed_axes(yaw).T


@pytest.mark.parametrize(
    ("degrees", "kind"),
    [
        (20, {}),
        (35, {"yaw": 0.7}),
        (50, {"height": 0.45, "width": 0.8, "level": 1.05, "arms": 0.2}),
        (42, {"height": 0.28, "width": 0.58, "back": 0.9, "yaw": -2.0}),
    ],
    ids=["sun lounger", "turned", "recliner", "deck chair"],
)
def test_the_trunk_lies_on_the_raised_back(degrees, kind):
    mesh = lounger(degrees, **kind)
    best = seats.seats_or_ring(seats.support_map(mesh), "lie")[1][0]
    yaw = kind.get("yaw", 0.0)
    assert best.reclined and best.goal.action == "lie"
    assert frames.wrap_angle(frames.direction_yaw(best.goal.direction) - yaw) == pytest.approx(0, abs=0.1)
    across, ahead = (best.goal.position @ frames.yawed_axes(yaw))[[0, 2]]
    assert abs(across) < 0.06 and -0.1 < ahead < 0.16
    points = sample_surface(mesh, 30_000, seed=0)[0]
    angle = reclining.back_angle(points, best.goal, best.goal.position[1] - BED_TO_PELVIS)
    assert np.degrees(angle) == pytest.approx(degrees, abs=5)


@pytest.mark.parametrize(
    "mesh",
    [
        lounger(0, level=1.4),
        np.concatenate([box((-0.7, 0, -1), (0.7, 0.45, 1)), box((-0.7, 0, -1.06), (0.7, 0.95, -1))]),
        np.concatenate([box((-0.7, 0, -1), (0.7, 0.45, 1)), box((-0.3, 0.45, -0.95), (0.3, 0.57, -0.6))]),
    ],
    ids=["flat lounger", "bed with a headboard", "bed with a pillow"],
)
def test_flat_beds_are_lain_on_flat(mesh):
    best = seats.seats_or_ring(seats.support_map(mesh), "lie")[1][0]
    assert not best.reclined
    points = sample_surface(mesh, 30_000, seed=0)[0]
    assert reclining.back_angle(points, best.goal, best.goal.position[1] - BED_TO_PELVIS) == 0


def test_an_upright_back_is_not_leaned_on():
    found = seats.seats_or_ring(seats.support_map(lounger(75)), "lie")[1]
    assert not any(seat.reclined for seat in found)


def test_a_goal_on_a_lounger_is_snapped():
    mesh = lounger(40)
    best = seats.seats_or_ring(seats.support_map(mesh), "lie")[1][0].goal
    assert seats.snap_goal(mesh, best).position == pytest.approx(best.position, abs=0.05)
