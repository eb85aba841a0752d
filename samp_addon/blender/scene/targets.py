"""Finds the piece of furniture that an artist has clicked."""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Vector

from ...errors import SampError
from ...scene.furniture import parts
from ..overlays.goal_arrows import TARGET_KEY
from . import candidates

LARGEST = 4.0
"""Largest width of furniture in metres; a larger parent is a part of the room."""


MOST_HITS, PAST = 64, 1e-3
"""Surfaces in front of a target that a click passes, and metres past each."""


def clicked_target(context: bpy.types.Context) -> str:
    """Return the name of the furniture that is active or selected; for a goal's arrow, its target.

    A click selects one cushion of a sofa whose parts have a common parent: the target is the highest parent
    of furniture size. Characters, lights, cameras and floors are skipped. Raise SampError where nothing fits.
    """
    active = context.view_layer.objects.active
    for obj in ([active] if active is not None else []) + list(context.selected_objects):
        if obj.get(TARGET_KEY):
            return obj[TARGET_KEY]
        if candidates.is_furniture(obj):
            return whole(obj).name
    raise SampError(f"{candidates.why_none(context)}; select furniture, or choose a target.")


def is_room(context: bpy.types.Context, name: str) -> bool:
    """Return whether a target is wider than furniture, so that a click has to say which piece of it is meant."""
    obj = context.scene.objects.get(name)
    return obj is not None and obj.type == "MESH" and _width(obj) > LARGEST


def point_under(context: bpy.types.Context, x: int, y: int, name: str) -> tuple[float, float, float] | None:
    """Return the point (x, y, z) of a target under a place of the window, pixels, or None beside it."""
    ray = view_ray(context, x, y)
    return None if ray is None else hit(context, *ray, name)


def view_ray(context: bpy.types.Context, x: int, y: int) -> tuple[Vector, Vector] | None:
    """Return origin and direction of the ray through a place of the window, pixels, or None outside of 3D views."""
    from bpy_extras import view3d_utils

    for area in context.window.screen.areas:
        region = next((r for r in area.regions if r.type == "WINDOW"), None)
        if area.type != "VIEW_3D" or region is None:
            continue
        at = x - region.x, y - region.y
        if 0 <= at[0] < region.width and 0 <= at[1] < region.height:
            view = area.spaces.active.region_3d
            origin = view3d_utils.region_2d_to_origin_3d(region, view, at)
            return origin, view3d_utils.region_2d_to_vector_3d(region, view, at)
    return None


def hit(
    context: bpy.types.Context, origin: Vector, direction: Vector, name: str
) -> tuple[float, float, float] | None:
    """Return the first point of a target and its children on a ray, or None; other objects do not cover it."""
    target = context.scene.objects[name]
    own = {target.name, *(child.name for child in target.children_recursive)}
    depsgraph = context.evaluated_depsgraph_get()
    for _ in range(MOST_HITS):
        found, point, _, _, obj, _ = context.scene.ray_cast(depsgraph, origin, direction)
        if not found:
            return None
        if obj.name in own:
            return tuple(point)
        origin = point + direction * PAST
    return None


def _is_character(obj: bpy.types.Object) -> bool:
    return obj.type == "ARMATURE" or obj.find_armature() is not None


def whole(obj: bpy.types.Object) -> bpy.types.Object:
    """Return the highest parent of furniture size that has no floor of its own, as the root of a diorama has."""
    while (
        obj.parent
        and not _is_character(obj.parent)
        and _width(obj.parent) <= LARGEST
        and not _has_floor(obj.parent, obj)
    ):
        obj = obj.parent
    return obj


def _has_floor(root: bpy.types.Object, piece: bpy.types.Object) -> bool:
    """Return whether another child of a root is a slab under all of it."""
    whole = _box(root)
    size = whole[1] - whole[0]
    if size[0] * size[1] < parts.SMALLEST_ROOM or size[2] < parts.LOWEST_ROOM:
        return False
    for child in root.children_recursive:
        if child.type == "MESH" and child != piece and child not in piece.children_recursive:
            low, high = _box(child)
            wide = (high - low)[:2].prod() > parts.FLOOR_SHARE * size[0] * size[1]
            if wide and high[2] < whole[0, 2] + parts.SLAB:
                return True
    return False


def _box(obj: bpy.types.Object) -> np.ndarray:
    """Return the corners (2, 3) of the box around an object and its children, Blender's axes."""
    corners = [
        np.array(part.matrix_world)[:3] @ np.append(np.array(corner), 1.0)
        for part in [obj, *obj.children_recursive]
        if part.type == "MESH"
        for corner in part.bound_box
    ]
    return np.stack([np.min(corners, axis=0), np.max(corners, axis=0)]) if corners else np.zeros((2, 3))


def _width(obj: bpy.types.Object) -> float:
    """Return the horizontal extent in metres of an object and its children, from bounding boxes."""
    return float(np.ptp(_box(obj), axis=0)[:2].max())
