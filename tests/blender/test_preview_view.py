"""From which side a preview shows a take: where nothing is in the way."""

from __future__ import annotations

import math

import bpy
import layouts
import numpy as np
import pytest
from samp_blender.samp_addon.blender.render import contact_sheet, preview
from samp_blender.samp_addon.frames import to_blender
from samp_blender.tests.support.blender import rigs

TRACK = contact_sheet.Track(np.array([[0.0, 0.0, 0.9], [1.0, 0.0, 0.6]]), np.zeros(2))
"""A walk along +X, and facing that way."""

USUAL = contact_sheet.VIEWS[0].azimuth


def wall(name, azimuth):
    """Add a wall 2 m wide between the path and a camera at this azimuth, degrees."""
    angle = math.radians(azimuth)
    mesh = bpy.data.meshes.new(name)
    middle = np.array([0.5, 0.0, 0.0]) + 2.0 * np.array([math.cos(angle), math.sin(angle), 0.0])
    along = 1.2 * np.array([-math.sin(angle), math.cos(angle), 0.0])
    corners = [middle - along, middle + along, middle + along + [0, 0, 4], middle - along + [0, 0, 4]]
    mesh.from_pydata([tuple(corner) for corner in corners], [], [(0, 1, 2, 3)])
    bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, mesh))


@pytest.mark.parametrize(
    ("walls", "azimuth", "cut"),
    [
        ([], USUAL, False),
        ([USUAL], USUAL - 70, False),
        ([USUAL, USUAL - 70], USUAL + 65, False),
        ("room", USUAL, True),
    ],
)
def test_the_side_from_which_nothing_hides_the_body(walls, azimuth, cut):
    rigs.reset()
    if walls == "room":
        mesh = bpy.data.meshes.new("Room")
        points = to_blender(layouts.box((-1.5, -0.1, -1.5), (2.5, 3.0, 1.5))).reshape(-1, 3)
        mesh.from_pydata(points.tolist(), [], np.arange(len(points)).reshape(-1, 3).tolist())
        bpy.context.scene.collection.objects.link(bpy.data.objects.new("Room", mesh))
    else:
        for number, side in enumerate(walls):
            wall(f"Wall {number}", side)
    bpy.context.view_layer.update()
    moments = list(enumerate(TRACK.pelvis, start=1))
    view = preview.best_view(bpy.context, moments, TRACK)
    assert (view.azimuth, view.cut) == (azimuth, cut)
