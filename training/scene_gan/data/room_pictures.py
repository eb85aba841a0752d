"""Pictures of an empty room, from cameras that see the start of a window: colours by the corpus' renderer, depth."""

from __future__ import annotations

import numpy as np

from ....samp_addon.scene.camera_view import SIZE
from ...rooms.classes import PERSON
from ...rooms.corpus import views
from ...rooms.corpus.store import RoomData
from ...rooms.pictures import camera as cameras
from ...rooms.pictures import paints, shading
from ...rooms.pictures.camera import Camera
from ...rooms.pictures.tracer import Tracer
from .room_windows import in_view

FARTHEST = 60.0  # largest depth (m); farther, and beyond windows, it is 0
TRIES = 8  # cameras to try for one start
NEAR_EYE, NEAR_SHARE = 0.35, 0.15
"""A camera with more than this share of the picture nearer than this (metres) is obstructed."""


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


def of_room(
    data: RoomData, joints: np.ndarray, count: int, rng: np.random.Generator, colour: bool
) -> tuple[dict[str, np.ndarray], list[Camera], np.ndarray]:
    """Return at most ``count`` pictures, their cameras, and the starts (P,) for which they were chosen.

    joints: (W, 22, 3) of the starts, metres. Arrays: depth, classes, lens (P, 3), extrinsics (P, 4, 4), and if
    ``colour``, colour (P, H, W, 3) with random paints and light for each picture.
    """
    tracer, free = Tracer(data.room), views.free_places(data, rng)
    made: dict[str, list[np.ndarray]] = {
        name: [] for name in ("colour", "depth", "classes", "lens", "extrinsics")
    }
    chosen, starts = [], []
    for start in rng.choice(len(joints), 2 * count):
        if len(chosen) == count:
            break
        found = _camera(data, tracer, joints[start], free, rng)
        if found is None:
            continue
        camera, seen = found
        chosen.append(camera)
        starts.append(int(start))
        made["depth"].append(seen["depth"])
        made["classes"].append(seen["classes"])
        lens = camera.intrinsics(SIZE)
        made["lens"].append(np.array([lens[0, 0], lens[0, 2], lens[1, 2]]) / SIZE[0])
        made["extrinsics"].append(camera.extrinsics())
        if colour:
            room = data.room
            picture = shading.picture(
                tracer, camera, paints.draw(room, rng), paints.light(room, rng), None, rng, SIZE
            )
            made["colour"].append(picture.colour)
    out = {name: np.stack(values) for name, values in made.items() if values}
    for name in ("lens", "extrinsics"):
        if name in out:
            out[name] = out[name].astype(np.float32)
    return out, chosen, np.array(starts, int)


def _camera(
    data: RoomData, tracer: Tracer, joints: np.ndarray, free: np.ndarray, rng: np.random.Generator
) -> tuple[Camera, dict[str, np.ndarray]] | None:
    """Return a camera that sees a body (22, 3), and its maps of the empty room; None if none was found."""
    for _ in range(TRIES):
        found = cameras.draw(data.room, joints, free, rng)
        if found is None:
            return None
        seen = maps(tracer, found[0])
        close = (seen["depth"] > 0) & (seen["depth"] < 1000 * NEAR_EYE)
        if close.mean() < NEAR_SHARE and in_view(joints[None], found[0], seen["depth"])[0]:
            return found[0], seen
    return None
