"""The point of a floor, a seat or a bed under the mouse."""

from __future__ import annotations

import bpy
from mathutils import Vector

from ..scene import targets
from ..scene.candidates import OVERLAY_KEY


def surface_under(context: bpy.types.Context, x: int, y: int) -> tuple[float, float, float] | None:
    """Return the point of the scene under a place of the window, pixels, or None where there is nothing."""
    ray = targets.view_ray(context, x, y)
    return None if ray is None else surface_on(context, *ray)


def surface_on(
    context: bpy.types.Context, origin: Vector, direction: Vector
) -> tuple[float, float, float] | None:
    """Return the first point of the scene on a ray, past ghosts, overlays and characters, or None."""
    depsgraph = context.evaluated_depsgraph_get()
    for _ in range(targets.MOST_HITS):
        found, point, _, _, obj, _ = context.scene.ray_cast(depsgraph, origin, direction)
        if not found:
            return None
        if not obj.get(OVERLAY_KEY) and obj.find_armature() is None:
            return tuple(point)
        origin = point + direction * targets.PAST
    return None
