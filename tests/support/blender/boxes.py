"""Mesh objects made of boxes."""

from __future__ import annotations

import bpy
import rooms


def add_boxes(name, boxes, at):
    """Link a mesh of boxes (low and high corner, Y up) at a place of the scene, and return it."""
    points, faces = [], []
    for box in boxes:
        triangles = rooms.box(*box)
        faces += [tuple(len(points) + 3 * k + i for i in range(3)) for k in range(len(triangles))]
        points += [(x, -z, y) for x, y, z in triangles.reshape(-1, 3)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], faces)
    obj = bpy.data.objects.new(name, mesh)
    obj.location = at
    bpy.context.scene.collection.objects.link(obj)
    return obj
