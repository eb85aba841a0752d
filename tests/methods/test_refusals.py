"""A refusal names the object that is in the way, and says what to do."""

from __future__ import annotations

import numpy as np
import pytest
from samp_blender.samp_addon.clock import Clock
from samp_blender.samp_addon.errors import NoPlaceError, SampError
from samp_blender.samp_addon.methods.method import Draw
from samp_blender.samp_addon.methods.samp.planning import Planner
from samp_blender.samp_addon.methods.scene_view import SceneView
from samp_blender.samp_addon.methods.step import Step
from samp_blender.samp_addon.scene.geometry import SceneGeometry
from samp_blender.samp_addon.scene.seats import seats
from samp_blender.tests.support.layouts import box, moved

FLOOR = box((-3, -0.1, -3), (3, 0, 3))
CHAIR = np.concatenate(
    [
        box((-0.23, 0.4, -0.23), (0.23, 0.45, 0.23)),
        box((-0.23, 0.45, -0.23), (0.23, 0.9, -0.19)),
        *(box((x, 0, z), (x + 0.04, 0.4, z + 0.04)) for x in (-0.23, 0.19) for z in (-0.23, 0.19)),
    ]
)
TABLE = np.concatenate(
    [
        box((-0.7, 0.7, 0.0), (0.7, 0.74, 0.8)),
        *(box((x, 0, z), (x + 0.05, 0.7, z + 0.05)) for x in (-0.7, 0.65) for z in (0.0, 0.75)),
    ]
)
WALL = np.concatenate(
    [
        box((-3, 0, -1.6), (-0.45, 2.6, -1.5)),
        box((0.45, 0, -1.6), (3, 2.6, -1.5)),
        box((-0.45, 2.05, -1.6), (0.45, 2.6, -1.5)),
    ]
)
DOOR = box((-0.44, 0.01, -1.57), (0.44, 2.04, -1.53))
CAGE = np.concatenate(
    [box((-0.9, 0, z), (0.9, 1.2, z + 0.05)) for z in (-0.9, 0.9)]
    + [box((x, 0, -0.9), (x + 0.05, 1.2, 0.95)) for x in (-0.9, 0.9)]
)
BODY = box((-0.2, 0.5, -0.15), (0.2, 1.3, 0.2))
CRATE = box((-0.2, 0.46, -0.15), (0.2, 0.8, 0.2))


def sample(triangles, action, count, noise, obstacles=None, floor=None):
    """Stand in for GoalNet with the best places by geometry."""
    found = seats.find_goals(triangles, action, floor, obstacles)
    if not found:
        raise NoPlaceError("no place")
    return found[:1]


def refusal(others, characters=None, target=CHAIR, start=(0.0, 0.0, 2.3), turn=0.0, action="sit"):
    """Return the message for a target among other objects."""
    pieces = {"Floor": FLOOR, "Seat": target, **others}
    scene = SceneGeometry.from_objects((name, moved(mesh, turn)) for name, mesh in pieces.items())
    place = moved(np.array(start).reshape(1, 3), turn)[0]
    view = SceneView(scene, moved(target, turn), ("Seat",), start=(place, 0.0), characters=characters or {})
    with pytest.raises(SampError) as error:
        planner = Planner(Step(action=action, target="Seat"), view, sample, view.navmesh)
        planner.request(Draw(0, 0), Clock())
    return str(error.value)


@pytest.mark.parametrize("turn", [0.0, 0.5])
@pytest.mark.parametrize(
    ("others", "options", "words"),
    [
        ({"Desk": moved(TABLE, by=(0, 0, -0.02))}, {}, ("'Desk'", "'Seat'", "move them apart")),
        ({"Wall": WALL, "Gate": DOOR}, {"start": (0.0, 0.0, -2.5)}, ("'Gate' leaves no way", "'Seat'")),
        ({"Fence": CAGE}, {}, ("'Fence' leaves no way", "'Seat'")),
        ({"Body": BODY}, {"characters": {"Body": "Anna"}}, ("'Anna' is already on 'Seat'",)),
        ({"Crate": CRATE, "Lamp": box((2, 0, 2), (2.2, 1, 2.2))}, {}, ("'Crate' is in the way",)),
        ({"Shelf": box((-0.5, 0.95, -0.4), (0.5, 1.0, 0.6))}, {}, ("'Shelf' hangs only 0.95 m", "raise it")),
    ],
    ids=["a table", "a closed door", "a fence", "a character", "a crate", "a low shelf"],
)
def test_what_is_in_the_way_is_named(others, options, words, turn):
    message = refusal(others, turn=turn, **options)
    assert all(word in message for word in words), message
    assert "'Floor'" not in message and "'Lamp'" not in message and "'Wall'" not in message


@pytest.mark.parametrize(
    ("target", "words"),
    [
        (box((-0.4, 0, -0.4), (0.4, 0.1, 0.4)), "its top is only 0.10 m"),
        (box((-0.4, 1.4, -0.4), (0.4, 1.45, 0.4)), "begins 1.40 m above the floor"),
        (box((-60, 0, -60), (60, 45, 60)), "a unit of the scene is a metre"),
    ],
    ids=["low", "high", "in centimetres"],
)
def test_a_target_that_fits_nobody_says_what_fits(target, words):
    message = refusal({}, target=target, start=(-2.5, 0.0, -2.5))
    assert "'Seat'" in message and words in message, message
