"""A temporary scene to render takes: a floor, furniture, and a figure for each take."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from ...body import human
from ...frames import to_blender
from ...motion import Motion

FIGURE_COLOURS = ((0.25, 0.50, 0.88), (0.90, 0.42, 0.22), (0.30, 0.68, 0.38), (0.66, 0.34, 0.72))


def material(name: str, colour: tuple[float, float, float]) -> bpy.types.Material:
    """Create a material of this colour for Workbench."""
    made = bpy.data.materials.new(name)
    made.diffuse_color = (*colour, 1.0)
    return made


def add_mesh(scene: bpy.types.Scene, name: str, vertices: np.ndarray, faces: Sequence) -> bpy.types.Object:
    """Add a mesh object of vertices (V, 3) in the network frame and faces (F, 3 or 4)."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(to_blender(vertices).tolist(), [], [list(face) for face in faces])
    mesh.update()
    obj = bpy.data.objects.new(name, mesh)
    scene.collection.objects.link(obj)
    return obj


def add_floor(scene: bpy.types.Scene, centre: np.ndarray, radius: float) -> None:
    """Add a chequered floor of 0.5 m squares at height 0; its lines make foot slide visible."""
    low = np.floor((centre[[0, 2]] - radius) * 2).astype(int)
    high = np.ceil((centre[[0, 2]] + radius) * 2).astype(int)
    x, z = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]), indexing="ij")
    corners = np.stack([x.ravel(), z.ravel()], -1)[:, None] + np.array([[0, 0], [0, 1], [1, 1], [1, 0]])
    vertices = np.zeros((*corners.shape[:2], 3))
    vertices[..., [0, 2]] = corners / 2.0
    squares = np.arange(corners.shape[0] * 4).reshape(-1, 4).tolist()
    floor = add_mesh(scene, "Floor", vertices.reshape(-1, 3), squares)
    for name, colour in (("Floor light", (0.95, 0.93, 0.90)), ("Floor dark", (0.78, 0.76, 0.73))):
        floor.data.materials.append(material(name, colour))
    floor.data.polygons.foreach_set("material_index", ((x + z) % 2).ravel().astype(np.int32))


# Colours of the body's materials; clothes have the figure's own colour.
_PALETTE = {
    "skin": (0.83, 0.60, 0.47),
    "shoes": (0.12, 0.12, 0.13),
    "hair": (0.16, 0.10, 0.07),
    "eyes": (0.92, 0.92, 0.90),
    "pupils": (0.05, 0.04, 0.04),
}


class Figure:
    """A take's body, skinned frame by frame outside Blender: no armature, no Action."""

    def __init__(self, scene: bpy.types.Scene, motion: Motion, colour: tuple[float, float, float]) -> None:
        body = human.load()
        self._vertices = human.skin(body, motion)
        faces = [f[:3] if f[2] == f[3] else f for f in body.faces.tolist()]
        self.object = add_mesh(scene, "Figure", body.vertices, faces)
        for name in human.MATERIALS:
            self.object.data.materials.append(material(f"Figure {name}", _PALETTE.get(name, colour)))
        self.object.data.polygons.foreach_set("material_index", body.materials.astype(np.int32))
        self.object.data.polygons.foreach_set("use_smooth", np.ones(len(faces), bool))

    def show(self, frame: int) -> None:
        """Show a frame, clamped to the last one."""
        at = min(frame, len(self._vertices) - 1)
        points = to_blender(self._vertices[at]).astype(np.float32)
        self.object.data.vertices.foreach_set("co", points.ravel())
        self.object.data.update()


def build(
    motions: Sequence[Motion], triangles: np.ndarray | None = None
) -> tuple[bpy.types.Scene, list[Figure]]:
    """Create a scene with a floor, furniture (F, 3, 3) or None, and a figure for each take; network frame."""
    scene = bpy.data.scenes.new("SAMP stage")
    path = np.concatenate([m.root for m in motions])
    centre = (path.min(0) + path.max(0)) / 2
    add_floor(scene, centre, float(np.linalg.norm(np.ptp(path, axis=0))) / 2 + 2.5)
    if triangles is not None and len(triangles):
        points = np.asarray(triangles).reshape(-1, 3)
        piece = add_mesh(scene, "Furniture", points, np.arange(len(points)).reshape(-1, 3).tolist())
        piece.data.materials.append(material("Furniture", (0.72, 0.52, 0.34)))
    return scene, [Figure(scene, m, FIGURE_COLOURS[k % 4]) for k, m in enumerate(motions)]


def clear(scene: bpy.types.Scene) -> None:
    """Delete a stage with all its objects."""
    for obj in list(scene.objects):
        mesh = obj.data
        for used in list(mesh.materials):
            bpy.data.materials.remove(used)
        bpy.data.meshes.remove(mesh)
    bpy.data.scenes.remove(scene)
