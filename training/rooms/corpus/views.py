"""The pictures of a room: starts of 65-frame windows, each from its own camera."""

from __future__ import annotations

import functools

import numpy as np

from ....samp_addon.body import human
from ....samp_addon.motion import Motion
from ..classes import PERSON
from ..pictures import camera, paints, shading, tracer
from . import store

WINDOW = 65  # frames: the pictured one and the 64 after it
LEAST_SEEN = 0.35  # least visible share of a person
TRIES = 8  # cameras to try for one start
COARSE, CLOSE = (32, 18), (1.0, 0.15)  # rays; distance (m), and the share of a picture that may be closer
MARGIN = 0.2  # least distance (m) of a camera from objects


@functools.cache
def faces() -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles (F, 3) of the default human and their paints (F,)."""
    body = human.load()
    triangles = np.concatenate([body.faces[:, :3], body.faces[:, [0, 2, 3]]])
    material = np.concatenate([body.materials, body.materials])
    real = triangles[:, 0] != triangles[:, 2]
    real &= (triangles[:, 1] != triangles[:, 2]) & (triangles[:, 0] != triangles[:, 1])
    return triangles[real], (-1 - material[real]).astype(np.int16)


def pictures(data: store.RoomData, count: int, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return the arrays of ``count`` pictures of the room, or fewer where no camera sees a person.

    colour (P, 144, 256, 3) uint8. depth (P, 144, 256) uint16, millimetres along the camera's axis. normal (P, 144, 256,
    3) int8. classes (P, 144, 256) uint8. intrinsics (P, 3, 3), extrinsics (P, 4, 4) float32. episode, frame (P,).
    """
    seen = tracer.Tracer(data.room)
    free = free_places(data, rng)
    out: dict[str, list] = {name: [] for name in ("colour", "depth", "normal", "classes", "intrinsics", "extrinsics",
                                                   "episode", "frame")}  # fmt: skip
    starts = _starts(data, 3 * count, rng)
    for episode, frame in starts:
        if len(out["frame"]) == count:
            break
        motion = data.motion(episode, frame, 1)
        body = _body(data, episode, motion)
        view = _camera(data, seen, body[1], body[0], free, rng)
        if view is None:
            continue
        room = data.room
        made = shading.picture(seen, view, paints.draw(room, rng), paints.light(room, rng), body[0], rng)
        out["colour"].append(made.colour)
        out["depth"].append(np.clip(np.round(made.depth / store.DEPTH_UNIT), 0, 65535).astype(np.uint16))
        out["normal"].append(np.round(made.normal * store.NORMAL_UNIT).astype(np.int8))
        out["classes"].append(made.classes.astype(np.uint8))
        out["intrinsics"].append(view.intrinsics().astype(np.float32))
        out["extrinsics"].append(view.extrinsics().astype(np.float32))
        out["episode"].append(episode)
        out["frame"].append(frame)
    return {
        name: np.stack(values) if name not in ("episode", "frame") else np.array(values, np.int32)
        for name, values in out.items() if values or name in ("episode", "frame")
    }  # fmt: skip


def _starts(data: store.RoomData, count: int, rng: np.random.Generator) -> list[tuple[int, int]]:
    """Return random episodes and frames that are followed by a whole window."""
    bounds = np.array(data.bounds)
    lengths = np.diff(bounds) - WINDOW
    fits = np.flatnonzero(lengths > 0)
    if not len(fits):
        return []
    chosen = rng.choice(fits, count, p=lengths[fits] / lengths[fits].sum())
    return [(int(e), int(rng.integers(0, lengths[e] + 1))) for e in chosen]


def _body(data: store.RoomData, episode: int, motion: Motion) -> tuple[tracer.Body, np.ndarray]:
    """Return the body to render, and a sample of its skin (N, 3), metres."""
    skin = human.skin(data.body(episode), motion)[0]
    triangles, paint = faces()
    return tracer.Body(skin, triangles, paint), skin[::40]


def free_places(data: store.RoomData, rng: np.random.Generator) -> np.ndarray:
    """Return positions (M, 2), metres, for cameras: without objects between knee and head height."""
    room = data.room
    points = np.array(data.array("cloud", "points"))
    width, depth, _ = room.size
    places = rng.uniform(-1, 1, (600, 2)) * (np.array([width, depth]) / 2 - MARGIN)
    tall = points[(points[:, 1] > 0.8) & (points[:, 1] < 2.0)][:, [0, 2]]
    inner = (np.abs(tall) < np.array([width, depth]) / 2 - 0.05).all(-1)
    tall = tall[inner]
    if not len(tall):
        return places
    gap = np.array([np.min(((tall - p) ** 2).sum(-1)) for p in places])
    clear = places[gap > MARGIN**2]
    return clear if len(clear) else places


def _camera(
    data: store.RoomData, seen: tracer.Tracer, skin: np.ndarray, body: tracer.Body, free: np.ndarray,
    rng: np.random.Generator,
) -> camera.Camera | None:  # fmt: skip
    """Return a camera with LEAST_SEEN of the person in view, or None."""
    for _ in range(TRIES):
        found = camera.draw(data.room, skin, free, rng)
        if found is None:
            return None
        if _crowded(seen, found[0]):
            continue
        way = skin - found[0].position
        way /= np.linalg.norm(way, axis=-1, keepdims=True)
        eye = np.broadcast_to(found[0].position, way.shape)
        hit = seen.trace(eye, way, body)
        alone = body.scene.run(eye.astype(np.float32), way.astype(np.float32), output=True)
        # Only skin that faces the camera counts.
        facing = alone["primID"] >= 0
        visible = (hit.classes == PERSON)[facing]
        if facing.any() and visible.mean() > LEAST_SEEN and hit.distance.min() > 0.25:
            return found[0]
    return None


def _crowded(seen: tracer.Tracer, view: camera.Camera) -> bool:
    """Return whether close objects fill too much of a camera's picture."""
    ways = view.rays(COARSE).reshape(-1, 3)
    hit = seen.trace(np.broadcast_to(view.position, ways.shape), ways)
    return float((hit.distance < CLOSE[0]).mean()) > CLOSE[1]
