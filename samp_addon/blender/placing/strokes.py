"""Way-points from lines: drawn with the mouse on the floor, or the curve of an object."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from ...errors import SampError
from ...scene import strokes
from ..overlays import waypoints
from ..scene import read_scene


def add(context: bpy.types.Context, line: Sequence[Sequence[float]]) -> list[bpy.types.Object]:
    """Add the way-points of a line (N, 3), metres in Blender's world, after the existing ones."""
    return [waypoints.add(context, tuple(point)) for point in strokes.waypoints(np.array(line))]


def of_curve(context: bpy.types.Context, name: str) -> np.ndarray:
    """Return the way-points (K, 3) of a curve object, Blender's world, in the direction of its first spline.

    Raise SampError where there is no such object, or it is no curve with points.
    """
    obj = context.scene.objects.get(name)
    if obj is None:
        curves = [other.name for other in context.scene.objects if other.type == "CURVE"]
        known = read_scene.close_names(name, curves) or ", ".join(f"'{other}'" for other in curves[:5])
        raise SampError(
            f"There is no curve '{name}' in the scene; {f'there is {known}' if known else 'add it'}."
        )
    if obj.type != "CURVE":
        raise SampError(f"'{name}' is no curve; name a curve object as the path.")
    line = _points(obj)
    if len(line) < 2:
        raise SampError(f"The curve '{name}' has no points; draw it first.")
    world = np.array(obj.matrix_world, dtype=np.float64)
    return strokes.waypoints(line @ world[:3, :3].T + world[:3, 3])


def _points(obj: bpy.types.Object) -> np.ndarray:
    """Return the points (N, 3) along the first spline of a curve, in its own space, without bevel and extrusion."""
    data = obj.data.copy()
    bare = bpy.data.objects.new(obj.name, data)
    try:
        data.bevel_depth = data.extrude = data.offset = 0.0
        data.bevel_object = data.taper_object = None
        for spline in data.splines[1:]:
            data.splines.remove(spline)
        mesh = bare.to_mesh()
        points = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", points)
        bare.to_mesh_clear()
    finally:
        bpy.data.objects.remove(bare)
        bpy.data.curves.remove(data)
    return points.reshape(-1, 3).astype(np.float64)
