"""A stage to look at takes that no .blend holds: a floor, the furniture, a figure for each take."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from ..frames import to_blender
from ..motion import Motion
from ..skeleton import PARENTS

FIGURE_COLOURS = ((0.25, 0.50, 0.88), (0.90, 0.42, 0.22), (0.30, 0.68, 0.38), (0.66, 0.34, 0.72))


def material(name: str, colour: tuple[float, float, float]) -> bpy.types.Material:
    """A plain material that Workbench shows in this colour."""
    made = bpy.data.materials.new(name)
    made.diffuse_color = (*colour, 1.0)
    return made


def add_mesh(scene: bpy.types.Scene, name: str, vertices: np.ndarray, faces: np.ndarray) -> bpy.types.Object:
    """An object of vertices (V, 3) in the network frame and faces (F, 3 or 4)."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(to_blender(vertices).tolist(), [], np.asarray(faces).tolist())
    mesh.update()
    thing = bpy.data.objects.new(name, mesh)
    scene.collection.objects.link(thing)
    return thing


def add_floor(scene: bpy.types.Scene, centre: np.ndarray, radius: float) -> None:
    """A chequered floor of 0.5 m squares at height 0: a sliding foot shows against its lines."""
    low = np.floor((centre[[0, 2]] - radius) * 2).astype(int)
    high = np.ceil((centre[[0, 2]] + radius) * 2).astype(int)
    x, z = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]), indexing="ij")
    corners = np.stack([x.ravel(), z.ravel()], -1)[:, None] + np.array([[0, 0], [0, 1], [1, 1], [1, 0]])
    vertices = np.zeros((*corners.shape[:2], 3))
    vertices[..., [0, 2]] = corners / 2.0
    floor = add_mesh(scene, "Floor", vertices.reshape(-1, 3), np.arange(corners.shape[0] * 4).reshape(-1, 4))
    for name, colour in (("Floor light", (0.95, 0.93, 0.90)), ("Floor dark", (0.78, 0.76, 0.73))):
        floor.data.materials.append(material(name, colour))
    floor.data.polygons.foreach_set("material_index", ((x + z) % 2).ravel().astype(np.int32))


class Figure:
    """A take's body as a mesh that is put into each frame by its vertices."""

    def __init__(self, scene: bpy.types.Scene, motion: Motion, colour: tuple[float, float, float]) -> None:
        vertices, faces = _capsules(motion)
        self._vertices = to_blender(vertices).astype(np.float32)
        self.object = add_mesh(scene, "Figure", vertices[0], faces)
        self.object.data.materials.append(material("Figure", colour))
        self.object.data.polygons.foreach_set("use_smooth", np.ones(len(faces), bool))

    def show(self, frame: int) -> None:
        """Bring frame (the last one, where the take is shorter) up."""
        self.object.data.vertices.foreach_set(
            "co", self._vertices[min(frame, len(self._vertices) - 1)].ravel()
        )
        self.object.data.update()


def _capsules(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Octagonal bones: vertices (T, V, 3), faces (F, 4)."""
    joints, _ = motion.forward_kinematics()
    ring = 8
    angle = np.arange(ring) * 2 * np.pi / ring
    sections = ((-0.1, 0.5), (0.1, 1.0), (0.9, 0.9), (1.1, 0.4))
    vertices, faces = [], []
    for j in range(1, joints.shape[1]):
        start, end = joints[:, PARENTS[j]], joints[:, j]
        along = end - start
        length = np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1e-6)
        axis = along / length
        side = np.cross(axis, np.where(np.abs(axis[:, 2:]) < 0.9, [[0, 0, 1.0]], [[1.0, 0, 0]]))
        side /= np.linalg.norm(side, axis=-1, keepdims=True)
        other = np.cross(axis, side)
        radius = np.clip(0.22 * length, 0.035, 0.075)
        base = len(vertices) * ring
        for at, width in sections:
            circle = (
                np.cos(angle)[None, :, None] * side[:, None] + np.sin(angle)[None, :, None] * other[:, None]
            )
            vertices.append((start + along * at)[:, None] + circle * (radius * width)[:, None])
        for s in range(len(sections) - 1):
            for k in range(ring):
                a, b = base + s * ring + k, base + s * ring + (k + 1) % ring
                faces.append((a, b, b + ring, a + ring))
    return np.concatenate(vertices, axis=1), np.array(faces)


def build(
    motions: Sequence[Motion], triangles: np.ndarray | None = None
) -> tuple[bpy.types.Scene, list[Figure]]:
    """A new scene with a floor, furniture (F, 3, 3) or None, and a figure for each take; network frame."""
    scene = bpy.data.scenes.new("SAMP stage")
    path = np.concatenate([m.root for m in motions])
    centre = (path.min(0) + path.max(0)) / 2
    add_floor(scene, centre, float(np.linalg.norm(np.ptp(path, axis=0))) / 2 + 2.5)
    if triangles is not None and len(triangles):
        points = np.asarray(triangles).reshape(-1, 3)
        piece = add_mesh(scene, "Furniture", points, np.arange(len(points)).reshape(-1, 3))
        piece.data.materials.append(material("Furniture", (0.72, 0.52, 0.34)))
    return scene, [Figure(scene, m, FIGURE_COLOURS[k % 4]) for k, m in enumerate(motions)]


def clear(scene: bpy.types.Scene) -> None:
    """Remove a stage with all that stands on it."""
    for thing in list(scene.objects):
        mesh = thing.data
        for used in list(mesh.materials):
            bpy.data.materials.remove(used)
        bpy.data.meshes.remove(mesh)
    bpy.data.scenes.remove(scene)
