"""What a camera of the scene sees in some frames: colours, depth, and which object each pixel shows."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np

from ... import frames
from ...atomic_file import atomic_write
from ...errors import SampError
from ...scene.geometry import SceneGeometry
from ..character import characters
from ..render import camera_picture, workbench
from ..render.camera_picture import Tracer
from ..scene import read_scene
from . import grey_png

WIDTH = 480
"""Pixels; the height is that of the scene's format."""
TALLEST = 4.0
"""Height over width of the tallest picture."""
MILLIMETRES = 1000.0
INDEX = "cameras.json"
"""The file about all pictures; written last."""


def names(numbers: Sequence[int]) -> list[str]:
    """Return the names of the files for frames of these numbers."""
    kinds = (".png", "_depth.png", "_objects.png")
    return [*(f"{number:05d}{kind}" for number in numbers for kind in kinds), INDEX]


def chosen(first: int, last: int, count: int) -> list[int]:
    """Return at most `count` frames, evenly spaced from the first to the last."""
    return np.unique(np.linspace(first, last, count).round().astype(int)).tolist()


def write(
    context: bpy.types.Context, camera_name: str, numbers: Sequence[int], folder: Path, target: str = ""
) -> list[Path]:
    """Write three pictures for each frame, and one file about all; return them, that file last.

    camera_name: empty for the scene's active one. target: the furniture of the take. Changes the open scene's render
    settings and frame; save the file before. Raise SampError where there is no such camera, or pictures cannot be
    rendered or written.
    """
    scene = context.scene
    camera = camera_picture.find(context, camera_name)
    height = _height(scene.render)
    workbench.prepare(scene, WIDTH, height)
    scene.render.pixel_aspect_x = scene.render.pixel_aspect_y = 1.0
    for marker in scene.timeline_markers:  # they would switch the camera
        marker.camera = None
    scene.camera = camera
    entries, objects = [], {}
    try:
        for number in numbers:
            scene.frame_set(number)
            entries.append(_picture(context, camera, number, height, folder, objects))
        content = {
            "camera": camera.name, "width": WIDTH, "height": height, "depth_unit_m": 1 / MILLIMETRES,
            "objects": _described(context, objects, target), "frames": entries,
        }  # fmt: skip
        with atomic_write(folder / INDEX) as part:
            part.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    except (OSError, RuntimeError) as error:
        raise SampError(f"'{folder}' cannot be written ({error}); choose another --dataset.") from error
    return [folder / name for name in names(numbers)]


def intrinsics(scene: bpy.types.Scene, camera: bpy.types.Object) -> np.ndarray:
    """Return the camera's matrix (3, 3) in pixels for the scene's format: x to the right, y down, from the upper left
    corner of the picture."""
    size = np.array([scene.render.resolution_x, scene.render.resolution_y], dtype=np.float64)
    corners = np.array(camera.data.view_frame(scene=scene), dtype=np.float64)
    at = corners[:, :2] / -corners[:, 2:]
    low, high = at.min(0), at.max(0)
    focal = size / (high - low)
    return np.array(
        [[focal[0], 0.0, -low[0] * focal[0]], [0.0, focal[1], high[1] * focal[1]], [0.0, 0.0, 1.0]]
    )


def _height(render: bpy.types.RenderSettings) -> int:
    shape = render.resolution_y * render.pixel_aspect_y / (render.resolution_x * render.pixel_aspect_x)
    return max(2, round(WIDTH * min(shape, TALLEST)))


def _picture(
    context: bpy.types.Context,
    camera: bpy.types.Object,
    number: int,
    height: int,
    folder: Path,
    objects: dict[str, int],
) -> dict:
    """Write the pictures of the current frame; return what the index says of them.

    objects: numbers of the objects by name, from 1; new ones are added.
    """
    matrix, world_to_camera = intrinsics(context.scene, camera), camera_picture.extrinsics_of(context, camera)
    geometry = read_scene.read_scene(context)
    depth, shown = _traced(geometry, matrix, world_to_camera, (height, WIDTH))
    for name in geometry.names:
        objects.setdefault(name, len(objects) + 1)
    numbers = np.array([0, *(objects[name] for name in geometry.names)], dtype=np.uint16)
    colour, depth_name, objects_name = names([number])[:3]
    with atomic_write(folder / colour) as part:
        workbench.write_png(part, workbench.picture(context.scene))
    with atomic_write(folder / depth_name) as part:
        grey_png.write(part, np.round(depth * MILLIMETRES).astype(np.uint16))
    with atomic_write(folder / objects_name) as part:
        grey_png.write(part, numbers[shown + 1])
    extrinsics = world_to_camera.copy()
    extrinsics[:3, :3] = frames.to_blender(world_to_camera[:3, :3])
    return {
        "frame": number, "colour": colour, "depth": depth_name, "objects": objects_name,
        "intrinsics": matrix.tolist(), "extrinsics": np.round(extrinsics, 9).tolist(),
    }  # fmt: skip


def _traced(
    geometry: SceneGeometry, matrix: np.ndarray, extrinsics: np.ndarray, size: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray]:
    """Return depth (H, W) along the camera's axis, metres, 0 where nothing is, and the object (H, W), -1 there."""
    y, x = np.mgrid[: size[0], : size[1]] + 0.5
    local = np.stack([x, y, np.ones_like(x)], -1).reshape(-1, 3) @ np.linalg.inv(matrix).T
    length = np.linalg.norm(local, axis=-1)
    if not len(geometry):
        return np.zeros(size), np.full(size, -1)
    eye = -extrinsics[:3, :3].T @ extrinsics[:3, 3]
    ways = local @ extrinsics[:3, :3] / length[:, None]
    hits = Tracer(geometry.triangles).trace(np.broadcast_to(eye, ways.shape), ways)
    seen = hits.face >= 0
    depth = np.where(seen, hits.distance / length, 0.0)
    shown = np.where(seen, geometry.object_ids[hits.face], -1)
    return depth.reshape(size), shown.reshape(size)


def _described(context: bpy.types.Context, objects: dict[str, int], target: str) -> list[dict]:
    """Return number, name, class and pass index of the objects. Classes: character, target, scene."""
    bodies = {obj.name for obj in read_scene.with_dependants(context, characters.people(context))}
    parts = (
        set(read_scene.read_target(context, target, characters.people(context)).parts) if target else set()
    )
    found = []
    for name, number in objects.items():
        kind = "character" if name in bodies else "target" if name in parts else "scene"
        obj = context.scene.objects.get(name)
        found.append(
            {"number": number, "name": name, "class": kind, "pass_index": obj.pass_index if obj else 0}
        )
    return found
