"""What a method needs to know of a test room."""

from __future__ import annotations

from dataclasses import replace

from samp_blender.samp_addon.methods.take import Situation
from samp_blender.samp_addon.scene.geometry import SceneGeometry


def situation(room, **changes):
    pieces = [("Floor", room.floor)] + [(piece.name, piece.triangles) for piece in room.pieces]
    made = Situation(
        SceneGeometry.from_objects(pieces),
        room.target.triangles,
        (room.target.name,),
        (room.start, room.start_yaw),
    )
    return replace(made, **changes)
