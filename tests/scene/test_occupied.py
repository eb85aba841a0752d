"""Paths lead around ground that other bodies stand on."""

from __future__ import annotations

import numpy as np
import pytest
import rooms
from samp_blender.samp_addon.errors import PathError
from samp_blender.samp_addon.scene.navmesh import navmesh, occupied, path

FLOOR = rooms.box((-2, -0.1, -2), (2, 0, 2))
START, END = np.array([-1.5, 0.0, 0.0]), np.array([1.5, 0.0, 0.0])


@pytest.mark.parametrize("radius", [0.2, 0.4])
def test_the_path_keeps_off(radius):
    mesh = navmesh.build(FLOOR)
    blocked = occupied.without(mesh, [(np.zeros(3), radius)])
    assert blocked.area < mesh.area
    line = path.plan(blocked, START, END).waypoints
    share = np.linspace(0, 1, 50)[:, None]
    dense = np.concatenate([a + share * (b - a) for a, b in zip(line[:-1], line[1:], strict=True)])
    assert np.hypot(*dense[:, [0, 2]].T).min() > radius + mesh.agent.radius - 0.08
    assert len(path.plan(mesh, START, END).waypoints) == 2


def test_nothing_is_changed_without_bodies_and_on_other_storeys():
    mesh = navmesh.build(FLOOR)
    assert occupied.without(mesh, []) is mesh
    assert occupied.without(mesh, [(np.array([0.0, 3.0, 0.0]), 0.5)]).area == mesh.area


def test_a_full_room_is_refused():
    with pytest.raises(PathError, match="Other characters"):
        occupied.without(navmesh.build(FLOOR), [(np.zeros(3), 9.0)])
