"""The pieces of a set of furniture, such as a table with its chairs, of which several characters take one each."""

from __future__ import annotations

import bpy
import numpy as np

from ..scene import read_scene

TALL = 0.25
"""Least height in metres of a piece of its own; cushions are lower."""

ON_FLOOR = 0.15
"""Metres over the lowest point of the set at which a piece of its own begins at most."""


def pieces(context: bpy.types.Context, name: str) -> tuple[str, ...]:
    """Return the names of the pieces of a collection or an empty, or the name itself where it is one piece.

    A piece stands on the floor and is no cushion. Raise SampError where there is no such object or collection.
    """
    found = read_scene.find_target(context, name)
    if isinstance(found, bpy.types.Collection):
        members = [
            obj for obj in found.all_objects if obj.parent is None or obj.parent.name not in found.all_objects
        ]
    elif isinstance(found, bpy.types.Object) and found.type == "EMPTY" and found.instance_type == "NONE":
        members = list(found.children)
    else:
        return (name,)
    boxes = {obj.name: _box(obj) for obj in members}
    boxes = {key: box for key, box in boxes.items() if box is not None}
    if not boxes:
        return (name,)
    lowest = min(box[0, 2] for box in boxes.values())
    own = [
        key for key, box in boxes.items() if box[1, 2] - box[0, 2] >= TALL and box[0, 2] <= lowest + ON_FLOOR
    ]
    return tuple(own) if len(own) > 1 else (name,)


def _box(obj: bpy.types.Object) -> np.ndarray | None:
    """Return the corners (2, 3) of the box around an object and its children, Blender's axes, or None."""
    corners = [
        (np.array(part.matrix_world) @ np.append(np.array(corner), 1.0))[:3]
        for part in (obj, *obj.children_recursive)
        if part.type in read_scene.SURFACE_TYPES or part.instance_type == "COLLECTION"
        for corner in part.bound_box
    ]
    return np.stack([np.min(corners, axis=0), np.max(corners, axis=0)]) if corners else None
