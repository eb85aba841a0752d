"""Time to read, voxelise and build the navmesh of files with 5,000 objects or two million triangles.

The cost of checking the sidebar's buttons in these files is measured as well.

python -m samp_blender.benchmarks.large
"""

from __future__ import annotations

import time
from collections.abc import Callable

import bpy
import numpy as np

from ..samp_addon.blender.scene import read_scene
from ..samp_addon.scene.navmesh import navmesh
from ..samp_addon.scene.seats import seats
from ..samp_addon.scene.voxels import InteractionGrid
from ..samp_addon.ui import job_from_settings
from ..tests.support import rooms

OBJECTS = 5000
ROWS = 1000  # of a grid of 2 * ROWS^2 triangles
RUNS = 3


def many_objects() -> str:
    """Build a room with a sofa, surrounded by boxes within 30 m; return a description."""
    _room()
    rng = np.random.default_rng(0)
    mesh = _mesh("Box", rooms.box(np.full(3, -0.2), np.full(3, 0.2)))
    for k in range(OBJECTS):
        obj = bpy.data.objects.new(f"Box {k}", mesh)
        angle, away = rng.uniform(0, 2 * np.pi), rng.uniform(6, 30)
        obj.location = (away * np.cos(angle), away * np.sin(angle), 0.2)
        bpy.context.scene.collection.objects.link(obj)
    return f"{OBJECTS} objects"


def many_triangles() -> str:
    """Build the same room next to hills of two million triangles; return a description."""
    _room()
    x, y = np.meshgrid(np.linspace(-10, 10, ROWS + 1), np.linspace(5, 25, ROWS + 1), indexing="ij")
    points = np.stack([x, y, 0.3 * np.sin(3 * x) * np.sin(3 * y) + 0.3], -1).reshape(-1, 3)
    corner = (np.arange(ROWS)[:, None] * (ROWS + 1) + np.arange(ROWS)).ravel()
    quads = np.stack([corner, corner + ROWS + 1, corner + ROWS + 2, corner + 1], -1)
    mesh = bpy.data.meshes.new("Hills")
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", points.astype(np.float32).ravel())
    mesh.loops.add(quads.size)
    mesh.loops.foreach_set("vertex_index", quads.astype(np.int32).ravel())
    mesh.polygons.add(len(quads))
    mesh.polygons.foreach_set("loop_start", np.arange(0, quads.size, 4, dtype=np.int32))
    mesh.update()
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Hills", mesh))
    return f"{2 * len(quads):,} triangles"


def _room() -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    rooms.to_blender(rooms.random_room(1, rooms.sofa), bpy.context.scene)


def _mesh(name: str, triangles: np.ndarray) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new(name)
    points = triangles.reshape(-1, 3)
    mesh.from_pydata(points.tolist(), [], np.arange(len(points)).reshape(-1, 3).tolist())
    return mesh


def _best(work: Callable[[], object]) -> float:
    times = []
    for _ in range(RUNS):
        begun = time.perf_counter()
        work()
        times.append(time.perf_counter() - begun)
    return min(times)


def main() -> None:
    """Print one line per file."""
    import samp_blender

    samp_blender.register()
    for build in (many_objects, many_triangles):
        name = build()
        bpy.context.view_layer.update()
        read = _best(lambda: read_scene.read_scene(bpy.context))
        scene = read_scene.read_scene(bpy.context)
        walk = _best(lambda triangles=scene.triangles: navmesh.build(triangles))
        target = read_scene.read_target(bpy.context, "Sofa")
        voxels = _best(
            lambda piece=target.triangles: InteractionGrid.build(piece, seats.infer_front_yaw(piece))
        )
        ask = _best(lambda: [job_from_settings.why_not(bpy.context) for _ in range(100)]) / 100
        print(
            f"{name}: read {read:.2f} s, navmesh {walk:.2f} s, voxels {voxels:.2f} s, together "
            f"{read + walk + voxels:.2f} s; check whether the button is enabled {1e3 * ask:.3f} ms",
            flush=True,
        )
    samp_blender.unregister()


if __name__ == "__main__":
    main()
