"""Test rooms as a method sees them, and takes in them."""

from __future__ import annotations

from dataclasses import replace

import fakes
from samp_blender.samp_addon.methods.scene_view import SceneView
from samp_blender.samp_addon.pipeline import driver
from samp_blender.samp_addon.pipeline.driver import Work
from samp_blender.samp_addon.scene.geometry import SceneGeometry


def view_of(room, **changes):
    """A test room as a step sees it."""
    pieces = [("Floor", room.floor)] + [(piece.name, piece.triangles) for piece in room.pieces]
    made = SceneView(
        SceneGeometry.from_objects(pieces),
        room.target.triangles,
        (room.target.name,),
        (room.start, room.start_yaw),
    )
    return replace(made, **changes)


def takes_of(job, *views, tools=fakes.TOOLS, **keywords):
    """Takes and failures of a job whose steps see these views."""
    return driver.run(Work(job, views), tools=tools, **keywords)
