"""A room's pictures without the person: exact maps by tracing the room again, colours filled from around."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from ...rooms.classes import PERSON
from ...rooms.corpus.store import RoomData
from ...rooms.pictures.camera import Camera
from ...rooms.pictures.tracer import Tracer

SIZE = (128, 72)  # width and height
GROWN = 3  # pixels by which the removed outline of a person is larger than the person: shadows touch it
FARTHEST = 60.0  # metres of depth that are kept; farther, and beyond windows, is 0


def camera_of(intrinsics: np.ndarray, extrinsics: np.ndarray, width: int) -> Camera:
    """Return the camera of a corpus picture that is ``width`` pixels wide."""
    turn, shift = extrinsics[:3, :3].astype(np.float64), extrinsics[:3, 3].astype(np.float64)
    axes = turn * np.array([[1.0], [-1.0], [-1.0]])
    return Camera(-turn.T @ shift, axes, 2 * np.arctan(width / 2 / float(intrinsics[0, 0])))


def cleaned(colour: np.ndarray, person: np.ndarray) -> np.ndarray:
    """Return a picture (H, W, 3) uint8 whose marked pixels (H, W) have the colour of the nearest other one."""
    hidden = ndimage.binary_dilation(person, iterations=GROWN) if person.any() else person
    if hidden.all() or not hidden.any():
        return colour
    rows, columns = ndimage.distance_transform_edt(hidden, return_distances=False, return_indices=True)
    return colour[rows, columns]


def smaller(colour: np.ndarray, size: tuple[int, int] = SIZE) -> np.ndarray:
    """Return a picture (H, W, 3) uint8 reduced by a whole number to a size (width, height)."""
    factor = colour.shape[1] // size[0]
    blocks = colour.reshape(size[1], factor, size[0], factor, 3).mean((1, 3))
    return np.round(blocks).astype(np.uint8)


def maps(tracer: Tracer, camera: Camera, size: tuple[int, int] = SIZE) -> dict[str, np.ndarray]:
    """Return the empty room's depth (H, W) uint16 in millimetres and classes (H, W) uint8."""
    width, height = size
    rays = camera.rays(size).reshape(-1, 3)
    hits = tracer.trace(np.broadcast_to(camera.position, rays.shape), rays)
    ahead = np.where(np.isfinite(hits.distance), hits.distance * -(rays @ camera.axes[2]), 0.0)
    ahead = np.where(ahead < FARTHEST, ahead, 0.0)
    return {
        "depth": np.round(ahead * 1000).astype(np.uint16).reshape(height, width),
        "classes": np.minimum(hits.classes, PERSON - 1).astype(np.uint8).reshape(height, width),
    }


def of_room(data: RoomData, size: tuple[int, int] = SIZE) -> dict[str, np.ndarray]:
    """Return the arrays of all pictures of a room: colour, depth, classes, lens (P, 3), extrinsics (P, 4, 4),
    and episode and frame (P,) of the person who was in each."""
    made: dict[str, list[np.ndarray]] = {name: [] for name in ("colour", "depth", "classes", "lens")}
    tracer = Tracer(data.room)
    frame = np.array(data.array("pictures", "frame"))
    for number in range(len(frame)):
        colour = np.array(data.array("pictures", "colour")[number])
        person = np.array(data.array("pictures", "classes")[number]) == PERSON
        intrinsics = np.array(data.array("pictures", "intrinsics")[number], np.float64)
        width = colour.shape[1]
        camera = camera_of(intrinsics, np.array(data.array("pictures", "extrinsics")[number]), width)
        made["colour"].append(smaller(cleaned(colour, person), size))
        for name, values in maps(tracer, camera, size).items():
            made[name].append(values)
        made["lens"].append(np.array([intrinsics[0, 0], intrinsics[0, 2], intrinsics[1, 2]]) / width)
    out = {name: np.stack(values) for name, values in made.items() if values}
    if "lens" in out:
        out["lens"] = out["lens"].astype(np.float32)
    extrinsics = np.array(data.array("pictures", "extrinsics"), np.float32) if len(frame) else None
    return out | {
        "extrinsics": extrinsics,
        "episode": np.array(data.array("pictures", "episode")),
        "frame": frame,
    }
