"""What a camera sees, as Scene GAN sees it: a small picture with depth, without touching the scene or its settings.

The picture is traced here, not rendered: the same in a window and in a background process without a screen, and of the
same kind as the pictures that the networks were trained on (training/rooms/pictures): one lamp with a soft shadow,
light from all around, a picture that is exposed by what is seen. Textures count by their object's base colour.
"""

from __future__ import annotations

import difflib

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ... import frames
from ...errors import SampError
from ...scene.camera_view import SIZE, CameraView
from ...scene.geometry import SceneGeometry
from . import picture_light, surface_colours

HALF_WIDTHS = (np.tan(np.radians(22.0)), np.tan(np.radians(48.0)))
"""Tangents of half the narrowest and the widest picture; the networks know lenses of 50 to 84 degrees."""
FARTHEST = 60.0  # metres
BLOCKED, BLOCKED_SHARE = 0.25, 0.5
"""A camera is inside something where more than this share of what it sees is nearer than this, metres."""
EMPTY_SHARE = 0.1  # of the picture; a camera that sees less of the scene sees nothing
BLACK = 8  # of 255: the brightest tenth of a black picture is darker
STOREY = 4.0  # metres around the view's cone in which triangles are kept: they cast shadows


def take(context: bpy.types.Context, name: str, geometry: SceneGeometry) -> CameraView:
    """Return what a camera sees of a scene's geometry.

    name: of the camera; empty: the scene's active one. Raise SampError where there is none, where it is no perspective
    camera, or where it sees nothing of the scene.
    """
    camera = find(context, name)
    lens, extrinsics = _lens(context.scene, camera), extrinsics_of(context, camera)
    empty = CameraView(
        camera.name, np.zeros((*SIZE[::-1], 3), np.uint8), np.zeros(SIZE[::-1]), lens, extrinsics
    )
    kept = _near_view(geometry, empty)
    if not len(kept):
        raise _sees_nothing(camera)
    triangles = geometry.triangles[kept]
    scene = Tracer(triangles)
    rays = _rays(empty)
    hits = scene.trace(np.broadcast_to(empty.eye, rays.shape), rays)
    _check(camera, geometry, kept, hits)
    axis = extrinsics[2, :3]
    depth = np.where(hits.face >= 0, hits.distance * (rays @ axis), 0.0).reshape(SIZE[::-1])
    colours = surface_colours.of_objects(context, geometry.names)
    base = np.where(
        (hits.face >= 0)[:, None], colours[geometry.object_ids[kept[hits.face]]], picture_light.SKY
    )
    colour = picture_light.lit(scene, hits, base, empty.eye).reshape(*SIZE[::-1], 3)
    if np.quantile(colour.max(-1), 0.9) < BLACK:
        raise SampError(f"Camera '{camera.name}' sees only black surfaces; give the room lighter materials.")
    return CameraView(camera.name, colour, depth, lens, extrinsics)


def find(context: bpy.types.Context, name: str) -> bpy.types.Object:
    """Return the camera of this name, or the scene's active one. Raise SampError where it cannot be used."""
    scene = context.scene
    cameras = [obj.name for obj in scene.objects if obj.type == "CAMERA"]
    camera = scene.objects.get(name) if name else scene.camera
    if camera is None and not name:
        raise SampError(
            "The scene has no active camera; add one that sees the room, or name one with --camera."
        )
    if camera is None or camera.type != "CAMERA":
        near = difflib.get_close_matches(name, cameras, n=3, cutoff=0.3) or cameras[:3]
        known = ", ".join(f"'{other}'" for other in near)
        advice = f"choose one of {known}" if known else "add one that sees the room"
        raise SampError(f"There is no camera '{name or camera.name}' in the scene; {advice}.")
    kind = {"ORTHO": "orthographic", "PANO": "panoramic"}.get(camera.data.type, "")
    if camera.data.type != "PERSP":
        raise SampError(
            f"Camera '{camera.name}' is {kind or 'of a special kind'}; make it a perspective camera."
        )
    return camera


class Hits:
    """Where rays (N) hit: face (N,) or -1, distance (N,) metres, point (N, 3), normal (N, 3) towards the origin."""

    def __init__(self, face: np.ndarray, distance: np.ndarray, point: np.ndarray, normal: np.ndarray) -> None:
        self.face, self.distance, self.point, self.normal = face, distance, point, normal


class Tracer:
    """Triangles (F, 3, 3), ready for rays."""

    def __init__(self, triangles: np.ndarray) -> None:
        corners = np.arange(3 * len(triangles)).reshape(-1, 3)
        self._tree = BVHTree.FromPolygons(
            triangles.reshape(-1, 3).tolist(), corners.tolist(), all_triangles=True
        )
        normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        self._normals = normal / np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-12)

    def trace(self, origins: np.ndarray, ways: np.ndarray) -> Hits:
        """Return the first hits of rays from origins (N, 3) along unit directions (N, 3)."""
        cast = self._tree.ray_cast
        found = [
            cast(Vector(origin), Vector(way), FARTHEST)
            for origin, way in zip(origins.tolist(), ways.tolist(), strict=True)
        ]
        face = np.array([-1 if f[2] is None else f[2] for f in found])
        distance = np.array([FARTHEST if f[3] is None else f[3] for f in found])
        normal = self._normals[face]
        normal = normal * np.where((normal * ways).sum(-1, keepdims=True) > 0, -1.0, 1.0)
        return Hits(face, distance, origins + distance[:, None] * ways, normal)

    def distances(self, origins: np.ndarray, ways: np.ndarray, farthest: np.ndarray) -> np.ndarray:
        """Return how far (N,) rays get, at most ``farthest`` (N,), metres."""
        cast = self._tree.ray_cast
        rows = zip(origins.tolist(), ways.tolist(), farthest.tolist(), strict=True)
        found = [cast(Vector(origin), Vector(way), far)[3] for origin, way, far in rows]
        return np.array(
            [far if hit is None else hit for hit, far in zip(found, farthest.tolist(), strict=True)]
        )


def _lens(scene: bpy.types.Scene, camera: bpy.types.Object) -> np.ndarray:
    """Return focal length and principal point (3,) of a 16:9 picture that holds the camera's, of any format."""
    corners = np.array(camera.data.view_frame(scene=scene))
    at = corners[:, :2] / -corners[:, 2:]
    low, high = at.min(0), at.max(0)
    middle, half = (low + high) / 2, (high - low) / 2
    aspect = SIZE[1] / SIZE[0]
    width = float(np.clip(max(half[0], half[1] / aspect), *HALF_WIDTHS))
    focal = 1 / (2 * width)
    return np.array([focal, 0.5 - focal * middle[0], aspect / 2 + focal * middle[1]])


def extrinsics_of(context: bpy.types.Context, camera: bpy.types.Object) -> np.ndarray:
    """Return the matrix (4, 4) from the network frame to camera coordinates."""
    world = np.array(camera.evaluated_get(context.evaluated_depsgraph_get()).matrix_world, dtype=np.float64)
    axes = frames.to_network((world[:3, :3] / np.linalg.norm(world[:3, :3], axis=0)).T)
    out = np.eye(4)
    out[:3, :3] = axes * np.array([[1.0], [-1.0], [-1.0]])
    out[:3, 3] = -out[:3, :3] @ frames.to_network(world[:3, 3])
    return out


def _rays(view: CameraView) -> np.ndarray:
    """Return unit directions (H W, 3) through the middles of the pixels, network frame."""
    x, y = np.meshgrid((np.arange(SIZE[0]) + 0.5) / SIZE[0], (np.arange(SIZE[1]) + 0.5) / SIZE[0])
    local = np.stack(
        [(x - view.lens[1]) / view.lens[0], (y - view.lens[2]) / view.lens[0], np.ones_like(x)], -1
    )
    ways = local.reshape(-1, 3) @ view.extrinsics[:3, :3]
    return ways / np.linalg.norm(ways, axis=-1, keepdims=True)


def _near_view(geometry: SceneGeometry, view: CameraView) -> np.ndarray:
    """Return the triangles (indices) that the camera may see or that are near what it sees."""
    triangles = geometry.triangles
    if not len(triangles):
        return np.zeros(0, int)
    seen = triangles @ view.extrinsics[:3, :3].T + view.extrinsics[:3, 3]
    ahead = seen[..., 2].max(1) > -STOREY
    near = seen[..., 2].min(1) < FARTHEST
    wide = STOREY + np.maximum(seen[..., 2].max(1), 0) / view.lens[0]
    beside = (seen[..., 0].min(1) < wide) & (seen[..., 0].max(1) > -wide)
    return np.flatnonzero(ahead & near & beside)


def _check(camera: bpy.types.Object, geometry: SceneGeometry, kept: np.ndarray, hits: Hits) -> None:
    """Raise SampError where a camera is inside something, or sees nothing."""
    hit = hits.face >= 0
    if hit.mean() < EMPTY_SHARE:
        raise _sees_nothing(camera)
    blocked = hit & (hits.distance < BLOCKED)
    if blocked.mean() > BLOCKED_SHARE:
        numbers, counts = np.unique(geometry.object_ids[kept[hits.face[blocked]]], return_counts=True)
        name = geometry.names[numbers[counts.argmax()]]
        raise SampError(
            f"Camera '{camera.name}' is inside '{name}' or right in front of it; move it into the room."
        )


def _sees_nothing(camera: bpy.types.Object) -> SampError:
    return SampError(f"Camera '{camera.name}' sees nothing of the scene; turn it to the room.")
