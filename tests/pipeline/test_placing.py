"""What is under a mouse: on which furniture a body would be, how, and why not."""

from __future__ import annotations

import numpy as np
import pytest
from samp_blender.samp_addon.body.balls import Track
from samp_blender.samp_addon.pipeline.cast.role import Other
from samp_blender.samp_addon.pipeline.placing import Placer
from samp_blender.samp_addon.scene.geometry import SceneGeometry
from shapes import box

PIECES = {
    "Floor": [box((-4, -0.1, -4), (4, 0, 4))],
    "Bench": [box((-3, 0, -0.25), (-1, 0.45, 0.25))],
    "Bed": [box((1, 0, -1), (2.6, 0.5, 1)), box((1, 0.5, -1.1), (2.6, 1.0, -1.0))],
    "Stool": [box((-0.2, 0, 2.3), (0.2, 0.45, 2.7))],
    "Shelf": [box((-0.6, 1.0, 2.0), (0.6, 1.1, 3.0))],
    "Counter": [box((-3, 0, -3.5), (-1, 1.1, -3))],
    "Wall": [box((-4, 0, 4), (4, 2.5, 4.1))],
    "Rug": [box((-0.8, 0, -1.9), (0.8, 0.02, -0.9))],
}
SCENE = SceneGeometry.from_objects([(name, np.concatenate(parts)) for name, parts in PIECES.items()])
DOWN = np.array([0.0, -1.0, 0.0])
START = np.array([0.0, 0.0, 0.5])


def target_of(name):
    return None if name in ("Floor", "Wall") else (name, (name,))


def ann():
    points = np.random.default_rng(0).uniform((-1.7, 0.4, -0.2), (-1.3, 1.3, 0.3), (100, 3))
    return Other("Ann", Track(points[None], np.full(100, 0.05), 10), np.array([-1.5, 0.63, 0.0]))


@pytest.fixture(scope="module")
def placer():
    made = Placer(SCENE, target_of, [ann()], START)
    made.survey()
    return made


def under(placer, x, z, **options):
    return placer.under(np.array([x, 3.0, z]), DOWN, **options)


@pytest.mark.parametrize(
    ("x", "z", "action", "target", "reason"),
    [
        (-2.5, 0.0, "sit", "Bench", ""),
        (1.8, 0.0, "lie", "Bed", ""),
        (0.0, 0.0, "walk", "", ""),
        (0.0, -1.4, "walk", "", ""),  # a rug is floor
        (-1.5, 0.0, "sit", "Bench", "'Ann' is already on 'Bench'."),
        (-2.0, -3.2, "sit", "Counter", "'Counter' is 1.10 m high here"),
    ],
)
def test_what_is_under_the_mouse(placer, x, z, action, target, reason):
    spot = under(placer, x, z)
    assert (spot.action, spot.target) == (action, target)
    assert spot.fits is not bool(reason) and spot.reason.startswith(reason)
    assert np.linalg.norm((spot.point - [x, 0, z])[[0, 2]]) < 0.45


def test_what_is_in_the_way_is_named(placer):
    spot = placer.under(np.array([0.0, 0.8, 0.5]), np.array([0.0, -0.35, 1.9]))
    assert spot.reason == "'Shelf' is in the way of a body on 'Stool'."


def test_a_floor_without_room(placer):
    spot = placer.under(np.array([0.4, 0.8, 2.9]), DOWN)
    assert (spot.action, spot.reason) == ("walk", "There is no room to stand or walk here.")


def test_walls_and_nothing(placer):
    assert placer.under(np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.3, 1.0])).reason == (
        "'Wall' is no floor, seat or bed."
    )
    assert placer.under(np.array([0.0, 1.0, 0.0]), -DOWN) is None


def test_other_ways_at_the_same_point_come_in_turn(placer):
    first = under(placer, 1.25, 0.0)
    found = [under(placer, 1.25, 0.0, choice=k) for k in range(first.choices)]
    assert first.choices >= 2
    assert {spot.action for spot in found} == {"sit", "lie"}
    assert under(placer, 1.25, 0.0, choice=first.choices).goal.action == first.action


def test_a_wanted_facing(placer):
    yaw = np.pi
    assert under(placer, -2.5, 0.0, yaw=yaw).yaw == pytest.approx(yaw, abs=1e-6)
    assert under(placer, 0.0, 0.0, yaw=0.5).yaw == pytest.approx(0.5)


def test_no_way_leads_there():
    ring = [box((-1, 0, -1), (1, 2, -0.9)), box((-1, 0, 0.9), (1, 2, 1)), box((-1, 0, -1), (-0.9, 2, 1))]
    ring.append(box((0.9, 0, -1), (1, 2, 1)))
    pieces = [("Floor", PIECES["Floor"][0]), ("Ring", np.concatenate(ring))]
    made = Placer(SceneGeometry.from_objects(pieces), target_of, (), np.array([3.0, 0.0, 3.0]))
    made.survey()
    assert under(made, 0.0, 0.0).reason == "No way leads here."


def test_ways_are_not_checked_before_the_ground_is_known():
    spot = under(Placer(SCENE, target_of), -2.5, 0.0)
    assert spot.fits and spot.action == "sit"


def test_postures_come_after_the_other_ways(placer):
    def postures_at(goal, triangles):
        return ("upright", "lean_back") if goal.action == "sit" and len(triangles) else ()

    made = Placer(SCENE, target_of, (), None, postures_at)
    plain = under(placer, 1.25, 0.0).choices
    ways = [under(made, 1.25, 0.0, choice=k) for k in range(under(made, 1.25, 0.0).choices)]
    assert [way.posture for way in ways[:plain]] == [""] * plain
    assert {(way.action, way.posture) for way in ways[plain:]} == {("sit", "upright"), ("sit", "lean_back")}
    turned = under(made, -2.5, 0.0, choice=under(Placer(SCENE, target_of), -2.5, 0.0).choices, yaw=np.pi)
    assert turned.posture == "upright" and turned.yaw == pytest.approx(np.pi, abs=1e-6)
