"""Parts of a mesh that are named by a material or a vertex group: the sofa of a room that is one mesh."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import bpy
import numpy as np

from ... import frames

WEIGHT = 0.5
"""Least weight of a vertex that belongs to a group."""


@dataclass(frozen=True)
class Region:
    """A part of a mesh. point: (3,) on it, metres, network frame."""

    obj: bpy.types.Object
    point: np.ndarray


def find_region(context: bpy.types.Context, name: str) -> Region | None:
    """Return the part OBJECT/NAME of a mesh by the name of a material or a vertex group, or None."""
    whole, _, part = name.rpartition("/")
    obj = context.scene.objects.get(whole)
    if obj is None or obj.type != "MESH":
        return None
    points = np.array(list(_of_material(obj, part)) or list(_of_group(obj, part))).reshape(-1, 3)
    if not len(points):
        return None
    # A point on the surface, also where the part surrounds its middle.
    nearest = points[np.linalg.norm(points - points.mean(axis=0), axis=1).argmin()]
    world = np.array(obj.matrix_world) @ np.append(nearest, 1.0)
    return Region(obj, frames.to_network(world[:3]))


def _of_material(obj: bpy.types.Object, name: str) -> Iterator[tuple[float, ...]]:
    slots = {k for k, slot in enumerate(obj.material_slots) if slot.material and slot.material.name == name}
    if slots:
        yield from (tuple(face.center) for face in obj.data.polygons if face.material_index in slots)


def _of_group(obj: bpy.types.Object, name: str) -> Iterator[tuple[float, ...]]:
    group = obj.vertex_groups.get(name)
    if group is not None:
        for vertex in obj.data.vertices:
            if any(g.group == group.index and g.weight >= WEIGHT for g in vertex.groups):
                yield tuple(vertex.co)
