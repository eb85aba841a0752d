"""Contact sheets: evenly spaced frames of a take from two sides, tiled to one picture."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ...frames import direction_yaw, to_blender
from ...motion import Motion
from ...skeleton import INDEX
from . import workbench

# A camera's sensor is 36 mm wide; with this lens a tile sees 40 degrees.
_FIELD_OF_VIEW = math.radians(40.0)


@dataclass(frozen=True)
class View:
    """A camera direction in degrees. azimuth: from the character's front, positive to its left.

    follow: whether the camera moves with the character; otherwise it is fixed and sees the whole path. cut: whether
    what stands between a fixed camera and the path, such as a wall, is cut away.
    """

    name: str
    azimuth: float
    elevation: float
    follow: bool = False
    cut: bool = False


VIEWS = (View("front", 35.0, 18.0), View("side", 100.0, 8.0))
CLOSE_VIEWS = tuple(replace(view, follow=True) for view in VIEWS)

# Factor on the distance at which the space around the path would just fit into the picture.
_FILLED = 0.85

# Clip objects that are more than this (metres) in front of the character in close-ups.
_REACH = 0.75


@dataclass(frozen=True)
class Track:
    """Path of the character for the camera, in Blender's world.

    pelvis: (T, 3) metres; front: (T,) radians from +X, counter-clockwise from above.
    """

    pelvis: np.ndarray
    front: np.ndarray

    @classmethod
    def of(cls, motion: Motion) -> Track:
        """Return a take's pelvis path and facing, smoothed over half a second."""
        joints, _ = motion.forward_kinematics()
        across = joints[:, INDEX["left_hip"]] - joints[:, INDEX["right_hip"]]
        across = across + joints[:, INDEX["left_shoulder"]] - joints[:, INDEX["right_shoulder"]]
        facing = np.cross(across, [0.0, 1.0, 0.0])
        width = min(max(int(motion.fps / 2), 1), len(motion))
        padded = np.pad(facing, ((width // 2, (width - 1) // 2), (0, 0)), mode="edge")
        kernel = np.ones(width) / width
        smooth = np.stack([np.convolve(padded[:, k], kernel, "valid") for k in range(3)], axis=-1)
        return cls(to_blender(motion.root), direction_yaw(smooth) - math.pi / 2)


def _aim(camera: bpy.types.Object, view: View, centre: np.ndarray, angle: float, distance: float) -> None:
    """Place the camera around a centre; `angle` is the direction of the front, radians."""
    outward = _outward(view, angle)
    rotation = outward.to_track_quat("Z", "Y").to_matrix().to_4x4()
    camera.matrix_world = Matrix.Translation(Vector(centre) + outward * distance) @ rotation


def _outward(view: View, angle: float) -> Vector:
    """Return the direction from the centre to the camera; `angle` is the direction of the front, radians."""
    turn, tilt = angle + math.radians(view.azimuth), math.radians(view.elevation)
    return Vector((math.cos(turn) * math.cos(tilt), math.sin(turn) * math.cos(tilt), math.sin(tilt)))


def eye(track: Track, view: View) -> Vector:
    """Return the location of the fixed camera of a view, from which the whole path is seen."""
    centre, angle, distance = _framing(track, 0, follow=False)
    return Vector(centre) + _outward(view, angle) * distance


def _framing(track: Track, at: int, follow: bool) -> tuple[np.ndarray, float, float]:
    """Return centre, front angle and distance of the camera for one frame."""
    if follow:
        centre = track.pelvis[at].copy()
        centre[2] -= 0.1
        return centre, float(track.front[at]), 1.0 / math.tan(_FIELD_OF_VIEW / 2)
    low, high = track.pelvis.min(0), track.pelvis.max(0)
    centre = (low + high) / 2
    radius = max(float(np.linalg.norm(high - low)) / 2 + 0.85, 1.15)
    return centre, float(track.front[-1]), _FILLED * radius / math.tan(_FIELD_OF_VIEW / 2)


def _radius(distance: float) -> float:
    """Return the radius, metres, of the space around the path that a fixed camera at a distance sees; see _framing."""
    return distance * math.tan(_FIELD_OF_VIEW / 2) / _FILLED


def add_camera(scene: bpy.types.Scene) -> bpy.types.Object:
    """Add a camera with the tiles' field of view and make it the scene's camera."""
    data = bpy.data.cameras.new("SAMP look")
    data.angle, data.clip_end = _FIELD_OF_VIEW, 200.0
    camera = bpy.data.objects.new("SAMP look", data)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return camera


@contextmanager
def own_camera(scene: bpy.types.Scene) -> Iterator[bpy.types.Object]:
    """Render with a camera of the sheet's own, also where timeline markers switch the scene's camera."""
    before = scene.camera
    bound = [(marker, marker.camera) for marker in scene.timeline_markers if marker.camera is not None]
    for marker, _ in bound:
        marker.camera = None
    camera = add_camera(scene)
    try:
        yield camera
    finally:
        bpy.data.cameras.remove(camera.data)
        for marker, shot in bound:
            marker.camera = shot
        scene.camera = before


@contextmanager
def shadows_of_bodies(scene: bpy.types.Scene) -> Iterator[None]:
    """Let only bodies cast shadows: theirs show foot contact, those of furniture are slow to render."""
    before = {obj: obj.display.show_shadows for obj in scene.objects if obj.type == "MESH"}
    try:
        for obj in before:
            obj.display.show_shadows = obj.find_armature() is not None or obj.name.startswith("Figure")
        yield
    finally:
        for obj, cast in before.items():
            obj.display.show_shadows = cast


def pictures(
    scene: bpy.types.Scene,
    track: Track,
    frames: Sequence[int],
    show: Callable[[int], None],
    view: View,
    *,
    size: tuple[int, int],
    labels: Sequence[str] | None = None,
) -> list[np.ndarray]:
    """Render frames (indices of the track) from one side as (H, W, 3); `show` sets the scene to a frame."""
    workbench.prepare(scene, *size)
    tiles = []
    with own_camera(scene) as camera, shadows_of_bodies(scene):
        for count, frame in enumerate(frames):
            show(frame)
            centre, angle, distance = _framing(track, frame, view.follow)
            camera.data.clip_start = _nearest_seen(view, distance)
            _aim(camera, view, centre, angle, distance)
            if labels is not None:
                workbench.stamp(scene, labels[count])
            tiles.append(workbench.picture(scene))
    return tiles


def _nearest_seen(view: View, distance: float) -> float:
    """Return the near clipping distance of the camera, metres. distance: from the camera to the centre."""
    if view.follow:
        return distance - _REACH
    return distance - _radius(distance) if view.cut else 0.1


def tile(tiles: Sequence[np.ndarray], columns: int) -> np.ndarray:
    """Tile pictures (H, W, 3) of equal size row by row, with a thin gap."""
    gap = 4
    tiles = [np.pad(t, ((0, gap), (0, gap), (0, 0)), constant_values=255) for t in tiles]
    blank = np.full_like(tiles[0], 255)
    rows = [list(tiles[k : k + columns]) for k in range(0, len(tiles), columns)]
    rows[-1] += [blank] * (columns - len(rows[-1]))
    return np.concatenate([np.concatenate(row, axis=1) for row in rows], axis=0)[:-gap, :-gap]


def contact_sheet(
    scene: bpy.types.Scene,
    track: Track,
    show: Callable[[int], None],
    path: str | Path,
    *,
    fps: float,
    count: int = 12,
    size: tuple[int, int] = (320, 320),
    views: Sequence[View] = VIEWS,
) -> Path:
    """Write a PNG with `count` evenly spaced frames of a take from each side, stamped with frame and time.

    track: path of the character. show: sets the scene to frame i of the track.
    """
    frames = np.unique(np.linspace(0, len(track.pelvis) - 1, count).round().astype(int)).tolist()
    tiles = []
    for view in views:
        labels = [f"{view.name}  {frame}  {frame / fps:.2f} s" for frame in frames]
        tiles += pictures(scene, track, frames, show, view, size=size, labels=labels)
        tiles += [np.full_like(tiles[0], 255)] * (-len(tiles) % min(6, len(frames)))
    workbench.write_png(path, tile(tiles, min(6, len(frames))))
    return Path(path)
