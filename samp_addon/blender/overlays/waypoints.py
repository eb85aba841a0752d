"""Way-points on the floor: empties that the artist drags, read back as points on the path."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from ... import frames
from ...errors import SampError
from ..scene.candidates import OVERLAY_KEY

COLLECTION = "SAMP Way-points"
NUMBER_KEY = "samp_waypoint"
"""Custom property of a way-point: its number in the order of the path."""
SIZE = 0.3


def add(context: bpy.types.Context, position: Sequence[float]) -> bpy.types.Object:
    """Add a way-point at a position (3,), metres in Blender's world, after the existing ones."""
    if not np.isfinite(position).all():
        raise SampError(
            "The way-point's position is not a finite number; put the 3D cursor on the floor first."
        )
    made = bpy.data.objects.new("Way-point", None)
    made.empty_display_type, made.empty_display_size = "CIRCLE", SIZE
    # An empty's circle is upright; rotate it to lie on the floor.
    made.rotation_euler = (np.pi / 2, 0.0, 0.0)
    made.location, made.show_in_front, made.show_name = position, True, True
    made[OVERLAY_KEY], made[NUMBER_KEY] = (
        True,
        1 + max((point[NUMBER_KEY] for point in all_waypoints(context)), default=0),
    )
    made.name = f"Way-point {made[NUMBER_KEY]}"
    _collection(context).objects.link(made)
    context.view_layer.update()
    return made


def all_waypoints(context: bpy.types.Context) -> list[bpy.types.Object]:
    """Return the scene's way-points in the order of the path."""
    found = [obj for obj in context.scene.objects if NUMBER_KEY in obj]
    return sorted(found, key=lambda obj: (obj[NUMBER_KEY], obj.name))


def positions(context: bpy.types.Context) -> list[np.ndarray]:
    """Return the positions (3,) of the visible way-points, network frame, metres."""
    visible = [point for point in all_waypoints(context) if point.visible_get()]
    return [frames.to_network(np.array(point.matrix_world.translation)) for point in visible]


def clear(context: bpy.types.Context) -> int:
    """Delete all way-points; return their number."""
    found = all_waypoints(context)
    delete(found)
    return len(found)


def delete(found: Sequence[bpy.types.Object]) -> None:
    """Delete way-points, and their collection if it is empty then."""
    for point in found:
        bpy.data.objects.remove(point)
    collection = bpy.data.collections.get(COLLECTION)
    if collection is not None and not collection.objects and collection.get(OVERLAY_KEY):
        bpy.data.collections.remove(collection)


def _collection(context: bpy.types.Context) -> bpy.types.Collection:
    """Return the way-points' collection, which is never rendered; create it if missing."""
    found = next((c for c in context.scene.collection.children if c.name.startswith(COLLECTION)), None)
    if found is None:
        found = bpy.data.collections.new(COLLECTION)
        found[OVERLAY_KEY], found.hide_render = True, True
        context.scene.collection.children.link(found)
    return found
