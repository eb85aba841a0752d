"""Build the stages of one room: layout, point cloud, motion, pictures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ....samp_addon import skeleton
from ....samp_addon.scene import geometry
from ..episodes import bodies, generation
from ..episodes.bank import LABELS, Bank
from ..episodes.scene import Scene
from ..episodes.search import Search
from ..layout import kinds, room, stock
from ..uses.use import Uses
from . import store, views

POINTS = 20_000  # points of a room's cloud
TRIES = 6  # layouts to try for one room
ALIKE = (5, 10)  # degrees within which a frame counts as captured
FEWEST_ENTRIES = 6  # accessible uses with which a layout is accepted at once


@dataclass
class RoomBuilder:
    """Resources shared by all rooms. stocks: by split. uses: sits and lies, or None to omit them."""

    cache: Path
    seed: int
    stocks: dict[str, stock.Stock]
    bank: Bank
    search: Search
    uses: Uses | None
    episodes: int

    def make(self, number: int, split: str, pictures: int) -> dict:
        """Build the missing stages of a room; return its entry of the manifest."""
        folder = store.room_folder(self.cache, number)
        scene = None
        if not store.has_stage(folder, "layout"):
            scene = self._layout(folder, number, split)
        data = store.RoomData(folder)
        if not store.has_stage(folder, "cloud"):
            store.write_stage(folder, "cloud", cloud(data.room, self.seed + number))
        if not store.has_stage(folder, "motion"):
            scene = scene or Scene(data.room, self.stocks[split].named(), self.uses)
            self._motion(folder, number, scene)
        if not store.has_stage(folder, "pictures") or store.notes(folder, "pictures")["wanted"] != pictures:
            rng = np.random.default_rng([self.seed, number, 3])
            arrays = views.pictures(data, pictures, rng)
            store.write_stage(folder, "pictures", arrays, {"wanted": pictures, "count": len(arrays["frame"])})
        return entry(self.cache, number, split)

    def _layout(self, folder: Path, number: int, split: str) -> Scene:
        """Write the first layout with enough accessible uses, or the best of TRIES; return its scene."""
        kind = list(kinds.KINDS)[number % len(kinds.KINDS)]
        best, most = None, -1
        for attempt in range(TRIES):
            made = room.furnish(kind, self.stocks[split], np.random.default_rng([self.seed, number, attempt]))
            # Rounded to the file's precision, so that a continued run reproduces the scene.
            made = replace(made, triangles=made.triangles.astype(np.float32).astype(np.float64))
            scene = Scene(made, self.stocks[split].named(), self.uses)
            places = sum(placed.use.down >= 0 for placed in scene.placed_uses)
            if places > most:
                best, most, kept = made, places, scene
            if most >= FEWEST_ENTRIES:
                break
        width, depth, height = best.size
        notes = {"kind": kind, "area": width * depth, "height": height, "items": len(best.names),
                 "triangles": len(best.triangles), "enters": int(most)}  # fmt: skip
        (folder / "layout").mkdir(parents=True, exist_ok=True)
        best.save(folder / "layout" / "room.npz")
        store.write_json(folder / "layout" / "notes.json", notes)
        return kept

    def _motion(self, folder: Path, number: int, scene: Scene) -> None:
        made, report = generation.episodes(
            self.bank, self.search, scene, self.episodes, [self.seed, number, 2]
        )
        store.write_stage(folder, "motion", motion_arrays(made), {
            "episodes": len(made), "frames": sum(len(e.piece) for e in made),
            "captured": {
                f"{name}_{limit}": _share(made, name, limit) for name in ("joined", "deviation") for limit in ALIKE
            },
            "sits": sum(int((np.diff((e.piece.labels == LABELS.index("sit")).astype(int)) == 1).sum()) for e in made),
            "lies": sum(int((np.diff((e.piece.labels == LABELS.index("lie")).astype(int)) == 1).sum()) for e in made),
            "report": dict(report),
        })  # fmt: skip


def entry(cache: Path, number: int, split: str) -> dict | None:
    """Return the manifest's entry of a room, None unless all of its stages are finished."""
    folder = store.room_folder(cache, number)
    if not all(store.has_stage(folder, stage) for stage in ("layout", "cloud", "motion", "pictures")):
        return None
    return {
        "number": number, "split": split, **store.notes(folder, "layout"), **store.notes(folder, "motion"),
        "pictures": store.notes(folder, "pictures")["count"],
    }  # fmt: skip


def _share(made: list[generation.Episode], name: str, limit: int) -> float:
    """Return the share of frames whose legs and trunk are within some degrees of a captured frame."""
    return float(np.concatenate([getattr(e, name) <= limit for e in made]).mean()) if made else 0.0


def motion_arrays(made: list[generation.Episode]) -> dict[str, np.ndarray]:
    """Return the arrays of a room's motion; the frames of all episodes are concatenated."""

    def every(frames: Callable[[generation.Episode], np.ndarray], kind: type, *shape: int) -> np.ndarray:
        parts = [np.asarray(frames(e)).astype(kind) for e in made]
        return np.concatenate([np.zeros((0, *shape), kind), *parts])

    return {
        "bounds": np.cumsum([0, *(len(e.piece) for e in made)]).astype(np.int32),
        "shapes": every(lambda e: e.build.shape[None], np.float32, len(bodies.SHAPES)),
        "root": every(lambda e: e.piece.root, np.float32, 3),
        "rotations": every(
            lambda e: np.round(e.piece.rotations * store.QUATERNION), np.int16, skeleton.BODY_COUNT, 4
        ),
        "labels": every(lambda e: e.piece.labels, np.uint8),
        "contacts": every(lambda e: np.round(generation.contacts(e.piece)), np.uint8, 5),
        "objects": every(lambda e: e.piece.object, np.int16),
        "source": every(lambda e: e.piece.source, np.int32),
        "deviation": every(lambda e: e.deviation, np.uint8),
    }


def cloud(made: room.Room, seed: int) -> dict[str, np.ndarray]:
    """Return points (POINTS, 3), metres, on surfaces visible from inside, with normals (int8) and classes."""
    width, depth, height = made.size
    half = np.array([width / 2, depth / 2])
    points, face = geometry.sample_surface(made.triangles, 3 * POINTS, seed=seed)
    triangles = made.triangles[face]
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-12)
    # Outer sides of the shell are invisible from inside; doors and windows are recessed.
    inside = (
        (np.abs(points[:, [0, 2]]) < half + 0.1).all(-1)
        & (points[:, 1] > -0.02)
        & (points[:, 1] < height + 0.02)
    )
    shell = made.objects[face] == room.SHELL_OBJECT
    inwards = -points * np.array([1.0, 0.0, 1.0]) / np.maximum(np.abs(points), 1e-6).max(-1, keepdims=True)
    inwards[:, 1] = height / 2 - points[:, 1]
    faces_in = (normal * inwards).sum(-1) > 0
    keep = np.flatnonzero(inside & (~shell | faces_in))
    rng = np.random.default_rng(seed)
    chosen = rng.choice(keep, POINTS, replace=len(keep) < POINTS)
    return {
        "points": points[chosen].astype(np.float32),
        "normals": np.round(normal[chosen] * store.NORMAL_UNIT).astype(np.int8),
        "classes": made.classes[face[chosen]],
    }
