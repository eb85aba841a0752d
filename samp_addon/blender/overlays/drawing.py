"""Draws voxels, navmesh and path as overlay objects in the scene.

They are in the collection "SAMP", are never rendered or read as scene, and can be deleted like any object.
"""

from __future__ import annotations

import bpy
import numpy as np

from ... import frames
from ...scene.navmesh.navmesh import NavMesh
from ...scene.navmesh.path import Path
from ...scene.voxels import InteractionGrid
from ..scene.candidates import OVERLAY_KEY

COLLECTION = "SAMP"
LIFT = 0.02
"""Height in metres of navmesh and path over the floor, against z-fighting."""
PATH_RADIUS = 0.02
"""Bevel radius of the path curve, metres."""
OCCUPANCY = "occupancy"
"""Name of the colour attribute with the voxels' occupancy."""
COLOURS = {"grid": (1.0, 0.55, 0.1, 1.0), "navmesh": (0.2, 0.55, 1.0, 1.0), "path": (1.0, 0.15, 0.3, 1.0)}
CUBE = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64) / 2
CUBE_FACES = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])


def draw_grid(context: bpy.types.Context, grid: InteractionGrid, target: str) -> bpy.types.Object:
    """Draw a cube for each cell near the surface, scaled by the cell's occupancy."""
    full = np.flatnonzero(grid.occupancy > 0)
    size = grid.occupancy[full][:, None, None] * grid.cell_size
    turn = np.stack([frames.yaw_direction(grid.yaw + np.pi / 2), (0, 1, 0), frames.yaw_direction(grid.yaw)])
    corners = grid.centres[full][:, None] + (CUBE * size) @ turn
    faces = CUBE_FACES + 8 * np.arange(len(full))[:, None, None]
    mesh = _mesh("SAMP Grid", frames.to_blender(corners).reshape(-1, 3), faces.reshape(-1, 4))
    brightness = np.repeat(grid.occupancy[full], 8).astype(np.float32)
    colour = mesh.color_attributes.new(OCCUPANCY, "FLOAT_COLOR", "POINT")
    colour.data.foreach_set("color", np.repeat(brightness[:, None], 4, axis=1).ravel())
    return _place(context, f"SAMP Grid {target}", mesh, COLOURS["grid"])


def draw_navmesh(context: bpy.types.Context, navmesh: NavMesh) -> bpy.types.Object:
    """Draw the walkable polygons as one mesh, slightly over the floor."""
    corners = frames.to_blender(navmesh.polygons + [0.0, LIFT, 0.0]).reshape(-1, 3)
    mesh = _mesh("SAMP Navmesh", corners, np.arange(len(corners)).reshape(-1, 4))
    obj = _place(context, "SAMP Navmesh", mesh, COLOURS["navmesh"])
    obj.show_wire = True
    return obj


def draw_path(context: bpy.types.Context, path: Path) -> bpy.types.Object:
    """Draw the way-points of a path as a curve, slightly over the floor."""
    curve = bpy.data.curves.new("SAMP Path", "CURVE")
    curve.dimensions, curve.bevel_depth = "3D", PATH_RADIUS
    points = frames.to_blender(path.waypoints + [0.0, LIFT, 0.0])
    spline = curve.splines.new("POLY")
    spline.points.add(len(points) - 1)
    spline.points.foreach_set("co", np.append(points, np.ones((len(points), 1)), axis=1).ravel())
    return _place(context, "SAMP Path", curve, COLOURS["path"])


def clear(context: bpy.types.Context) -> int:
    """Delete all voxel, navmesh and path overlays; return their number."""
    # Goal arrows and way-points have the same property, but are empties; ghosts of sub-goals are below their arrows.
    found = [
        obj
        for obj in context.scene.objects
        if obj.get(OVERLAY_KEY) and obj.data is not None and obj.parent is None
    ]
    for overlay in found:
        _remove(overlay)
    return len(found)


def _remove(overlay: bpy.types.Object) -> None:
    """Delete an overlay, and its data and materials if unused."""
    data = overlay.data
    materials = list(data.materials) if data is not None else []
    bpy.data.objects.remove(overlay)
    if data is not None and data.users == 0:
        bpy.data.batch_remove([data])
    bpy.data.batch_remove(
        [material for material in materials if material is not None and material.users == 0]
    )


def _mesh(name: str, points: np.ndarray, quads: np.ndarray) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], quads.tolist())
    mesh.update()
    return mesh


def _place(
    context: bpy.types.Context, name: str, data: bpy.types.ID, colour: tuple[float, float, float, float]
) -> bpy.types.Object:
    """Add an object to the overlay collection, replacing the previous one of this name."""
    collection = _collection(context)
    previous = next((obj for obj in collection.objects if obj.get(OVERLAY_KEY) == name), None)
    if previous is not None:
        _remove(previous)
    data.materials.append(_material(name.split(" ")[1], colour))
    obj = bpy.data.objects.new(name, data)
    obj[OVERLAY_KEY] = name
    obj.hide_render, obj.color = True, colour
    collection.objects.link(obj)
    context.view_layer.update()
    return obj


def _material(kind: str, colour: tuple[float, float, float, float]) -> bpy.types.Material:
    """Return the material of a kind of overlay."""
    name = f"SAMP {kind}"
    found = bpy.data.materials.get(name) or bpy.data.materials.new(name)
    found.diffuse_color = colour
    return found


def _collection(context: bpy.types.Context) -> bpy.types.Collection:
    children = context.scene.collection.children_recursive
    found = next((child for child in children if child.get(OVERLAY_KEY)), None)
    if found is None:
        found = bpy.data.collections.new(COLLECTION)
        found[OVERLAY_KEY], found.hide_render = True, True
        context.scene.collection.children.link(found)
    return found
