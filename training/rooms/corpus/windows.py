"""Lists over the whole corpus: windows of two seconds, single bodies, pictures with their windows."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from . import store

SECONDS, FPS = 2, 30
LENGTH = SECONDS * FPS + 1  # frames of a window: k = 61 of the long-term paper
APART = 0.5  # least distance (m) between the ends of a window
EVERY = 10  # frames between two bodies, 0.33 s
WANTED = {"train": 10_000, "test": 3_000}  # windows of each split
BODIES = 5_000


def write(cache: Path, rooms: list[dict], seed: int) -> dict[str, int]:
    """Write all lists; return their lengths.

    windows_SPLIT.npy: (N, 3) room, episode, first frame of LENGTH frames whose ends are at least APART from each other.
    bodies_SPLIT.npy: (N, 3) room, episode, frame. pictures_SPLIT.npy: (N, 4) room, number of the picture in it,
    episode, first frame of its window of 65 frames.
    """
    counts = {}
    for split in store.SPLITS:
        rng = np.random.default_rng([seed, store.SPLITS.index(split), 9])
        mine = [store.RoomData(store.room_folder(cache, r["number"])) for r in rooms if r["split"] == split]
        numbers = [r["number"] for r in rooms if r["split"] == split]
        lists = {
            "windows": _thinned([_windows(d) for d in mine], numbers, WANTED[split], rng),
            "bodies": _thinned([_bodies(d) for d in mine], numbers, None, rng),
            "pictures": _thinned([_pictures(d) for d in mine], numbers, None, rng),
        }
        for kind, rows in lists.items():
            np.save(cache / f"{kind}_{split}.npy", rows)
            counts[f"{kind}_{split}"] = len(rows)
    return counts


def _thinned(
    rows: list[np.ndarray], numbers: list[int], most: int | None, rng: np.random.Generator
) -> np.ndarray:
    """Return rows preceded by the room's number; at most ``most``, spread evenly over the rooms."""
    width = 1 + (rows[0].shape[1] if rows else 2)
    if most is not None and rows:
        share = -(-most // len(rows))
        rows = [part[np.sort(rng.permutation(len(part))[:share])] for part in rows]
    out = [np.column_stack([np.full(len(part), n), part]) for n, part in zip(numbers, rows, strict=True)]
    every = np.concatenate(out) if out else np.zeros((0, width))
    every = every[np.sort(rng.permutation(len(every))[:most])] if most is not None else every
    return every.astype(np.int32)


def _windows(data: store.RoomData) -> np.ndarray:
    """Return all windows (N, 2), episode and first frame, every half second, whose ends are at least APART."""
    root, bounds = np.array(data.array("motion", "root"))[:, [0, 2]], np.array(data.bounds)
    out = []
    for episode, (a, b) in enumerate(zip(bounds[:-1], bounds[1:], strict=True)):
        first = np.arange(a, b - LENGTH + 1, FPS // 2)
        far = np.linalg.norm(root[first + LENGTH - 1] - root[first], axis=-1) >= APART
        out.append(np.column_stack([np.full(far.sum(), episode), first[far] - a]))
    return np.concatenate(out) if out else np.zeros((0, 2), int)


def _bodies(data: store.RoomData) -> np.ndarray:
    bounds = np.array(data.bounds)
    return np.concatenate(
        [np.column_stack([np.full(-(-(b - a) // EVERY), e), np.arange(0, b - a, EVERY)])
         for e, (a, b) in enumerate(zip(bounds[:-1], bounds[1:], strict=True))] or [np.zeros((0, 2), int)]
    )  # fmt: skip


def _pictures(data: store.RoomData) -> np.ndarray:
    episode, frame = data.array("pictures", "episode"), data.array("pictures", "frame")
    return np.column_stack([np.arange(len(frame)), episode, frame])


def crop(
    points: np.ndarray, centre: np.ndarray, yaw: float, radius: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of a cloud (P, 3) within a horizontal radius of a centre (3,), metres, and those points.

    The points are in the frame of a body at the centre that faces yaw, radians; heights are unchanged.
    """
    rows = np.flatnonzero(np.hypot(*(points[:, [0, 2]] - centre[[0, 2]]).T) < radius)
    away = points[rows] - centre * np.array([1.0, 0.0, 1.0])
    c, s = np.cos(yaw), np.sin(yaw)
    return rows, np.column_stack(
        [away[:, 0] * c - away[:, 2] * s, away[:, 1], away[:, 0] * s + away[:, 2] * c]
    )
