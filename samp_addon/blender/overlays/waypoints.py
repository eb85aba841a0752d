"""Way-points that the artist puts on the floor: empties to be dragged, read back as places that a way passes."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from ... import frames
from ...errors import SampError
from ..scene.read_scene import OVERLAY_KEY

COLLECTION = "SAMP Way-points"
NUMBER_KEY = "samp_waypoint"
"""Custom property of a way-point: its number in the order in which the way passes it."""
SIZE = 0.3


def add(context: bpy.types.Context, place: Sequence[float]) -> bpy.types.Object:
    """A way-point at a place (3,), metres of the world, after those that are there."""
    if not np.isfinite(place).all():
        raise SampError("The way-point's place is not a number; put the 3D cursor on the floor first.")
    made = bpy.data.objects.new("Way-point", None)
    made.empty_display_type, made.empty_display_size = "CIRCLE", SIZE
    # The circle of an empty stands upright; way-points lie on the floor.
    made.rotation_euler = (np.pi / 2, 0.0, 0.0)
    made.location, made.show_in_front, made.show_name = place, True, True
    made[OVERLAY_KEY], made[NUMBER_KEY] = (
        True,
        1 + max((point[NUMBER_KEY] for point in of(context)), default=0),
    )
    made.name = f"Way-point {made[NUMBER_KEY]}"
    _collection(context).objects.link(made)
    context.view_layer.update()
    return made


def of(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The scene's way-points in their order."""
    found = [obj for obj in context.scene.objects if NUMBER_KEY in obj]
    return sorted(found, key=lambda obj: (obj[NUMBER_KEY], obj.name))


def places(context: bpy.types.Context) -> list[np.ndarray]:
    """Where the way-points stand, network frame, (3,) each; hidden ones do not count."""
    shown = [point for point in of(context) if point.visible_get()]
    return [frames.to_network(np.array(point.matrix_world.translation)) for point in shown]


def clear(context: bpy.types.Context) -> int:
    """Takes all way-points away; returns how many there were."""
    found = of(context)
    for point in found:
        bpy.data.objects.remove(point)
    collection = bpy.data.collections.get(COLLECTION)
    if collection is not None and not collection.objects and collection.get(OVERLAY_KEY):
        bpy.data.collections.remove(collection)
    return len(found)


def _collection(context: bpy.types.Context) -> bpy.types.Collection:
    """The way-points' collection, which is never rendered."""
    found = next((c for c in context.scene.collection.children if c.name.startswith(COLLECTION)), None)
    if found is None:
        found = bpy.data.collections.new(COLLECTION)
        found[OVERLAY_KEY], found.hide_render = True, True
        context.scene.collection.children.link(found)
    return found
