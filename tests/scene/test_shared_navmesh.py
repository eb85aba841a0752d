"""Navmeshes that jobs in one scene share."""

import layouts
import numpy as np
import pytest
from samp_blender.samp_addon.scene.navmesh import navmesh, shared

NEAR, FAR = np.array([[0.0, 0.0, 1.0]]), np.array([[9.0, 0.0, 12.0]])
ROOM = layouts.furnished(seed=2, pieces=2, triangles=500)
CRATE = layouts.box((-0.3, 0.0, -0.3), (0.3, 0.5, 0.3))
"""Has no floor: ground is laid around it."""


def same(one, other):
    return np.array_equal(one.points, other.points) and np.array_equal(one.pieces.owner, other.pieces.owner)


@pytest.mark.parametrize(
    ("scene", "agent", "cover", "known"),
    [
        (ROOM.copy(), navmesh.Agent(), NEAR, True),
        (ROOM.copy(), navmesh.Agent(), FAR, True),
        (ROOM.copy(), navmesh.Agent(radius=0.12), NEAR, False),
        (ROOM + [0.0, 0.1, 0.0], navmesh.Agent(), NEAR, False),
    ],
)
def test_an_equal_scene_with_a_floor_has_the_same_navmesh(scene, agent, cover, known):
    first = shared.shared(ROOM, navmesh.Agent(), NEAR)
    found = shared.shared(scene, agent, cover)
    assert (found is first) == known
    assert same(found, navmesh.build(scene, agent, cover=cover))


def test_laid_ground_reaches_the_places_of_each_job():
    near, far = (shared.shared(CRATE, navmesh.Agent(), cover) for cover in (NEAR, FAR))
    assert same(far, navmesh.build(CRATE, cover=FAR)) and not same(near, far)
    assert shared.shared(CRATE.copy(), navmesh.Agent(), NEAR.copy()) is near


def test_large_scenes_are_not_kept(monkeypatch):
    monkeypatch.setattr(shared, "LARGE", len(ROOM) - 1)
    scene = ROOM + 0.5
    assert shared.shared(scene, navmesh.Agent(), NEAR) is not shared.shared(scene, navmesh.Agent(), NEAR)
