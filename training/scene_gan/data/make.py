"""Build the data set of Scene GAN from a corpus of rooms.

python -m samp_blender.training.scene_gan.data.make --corpus cache/rooms --output cache/scene_gan

Each split has a folder of memory-mapped .npy files and what.json. Finished rooms are cached, so that another run only
adds the new rooms of a growing corpus. --no-colour omits the pictures' colours, which take most of the time and are not
needed by the views "geometry" and "height".
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import numpy as np

from ...rooms.corpus import store
from ...rooms.make import split_of
from . import heights, packing, room_pictures, room_windows
from .units import ROOT_UNIT

WINDOWS = 250  # random windows of a room
PICTURES = 50  # pictures of a room
PAIRS = 12  # windows of a picture
PER_WINDOW = ("root", "rotations", "labels")
SIZES = (("depth", "pictures"), ("root", "windows"), ("pairs", "pairs"))


def of_room(
    data: store.RoomData, counts: tuple[int, int, int], colour: bool, rng: np.random.Generator
) -> dict[str, np.ndarray] | None:
    """Return a room's arrays, indices counted within the room; None where no window is in view of a camera.

    counts: of windows, pictures, and windows of each picture.
    """
    chosen = room_windows.of_room(data, counts[0], rng)
    if not len(chosen["frame"]):
        return None
    motion = room_windows.motion(data, chosen)
    joints = room_windows.first_joints(motion, chosen["episode"])
    pictures, cameras, starts = room_pictures.of_room(data, joints, counts[1], rng, colour)
    if not cameras:
        return None
    rows = []
    for number, (camera, start) in enumerate(zip(cameras, starts, strict=True)):
        seen = np.flatnonzero(room_windows.in_view(joints, camera, pictures["depth"][number]))
        others = rng.permutation(seen[seen != start])[: counts[2] - 1]
        rows += [(number, window) for window in (start, *others)]
    # Keep only the windows in use.
    table = np.array(rows, np.int32)
    used, table[:, 1] = np.unique(table[:, 1], return_inverse=True)
    grid, corner = heights.grid(data.room.triangles)
    return {
        **pictures,
        **{name: motion[name][used] for name in PER_WINDOW},
        "root": np.round(motion["root"][used] / ROOT_UNIT).astype(np.int16),
        "body": chosen["episode"][used].astype(np.int32),
        "rest": motion["rest"],
        "pairs": table,
        "heights": grid[None],
        "corners": corner[None].astype(np.float32),
    }


def joined(rooms: list[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Return the concatenated arrays of rooms, with indices counted over all of them, and room_of_picture."""
    first = lambda room: {"room_of_picture": np.zeros(len(room["depth"]), np.int32)}
    return packing.joined([room | first(room) for room in rooms])


def write(folder: Path, arrays: dict[str, np.ndarray], notes: dict) -> None:
    """Write a split of the data set."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, values in arrays.items():
        np.save(folder / f"{name}.npy", values)
    counts = {name: len(arrays[name]) for name in ("depth", "root", "pairs", "heights") if name in arrays}
    store.write_json(folder / "what.json", notes | {"counts": counts})


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--corpus", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--windows", type=int, default=WINDOWS, help="windows of a room")
    parser.add_argument("--pictures", type=int, default=PICTURES, help="pictures of a room")
    parser.add_argument("--pairs", type=int, default=PAIRS, help="windows of a picture")
    parser.add_argument("--no-colour", action="store_true")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    began = time.time()
    counts = (options.windows, options.pictures, options.pairs)
    kept = options.output / "rooms"
    kept.mkdir(parents=True, exist_ok=True)
    for folder in sorted((options.corpus / "rooms").iterdir()):
        path = kept / f"{folder.name}.npz"
        if path.exists() or not all(store.has_stage(folder, stage) for stage in ("cloud", "motion")):
            continue
        rng = np.random.default_rng([options.seed, int(folder.name)])
        room = of_room(store.RoomData(folder), counts, not options.no_colour, rng)
        part = path.with_suffix(".part")
        with part.open("wb") as file:
            np.savez(file, **(room or {}))
        part.replace(path)
        if room is not None:
            sizes = ", ".join(f"{len(room[name])} {word}" for name, word in SIZES)
            print(f"room {folder.name}: {sizes}, {time.time() - began:.0f} s", flush=True)
    write_splits(kept, options.output, options.seed)
    return 0


def write_splits(kept: Path, output: Path, seed: int) -> None:
    """Write both splits from the cached rooms."""
    found: dict[str, list[dict[str, np.ndarray]]] = {name: [] for name in store.SPLITS}
    numbers: dict[str, list[int]] = {name: [] for name in store.SPLITS}
    for path in sorted(kept.glob("*.npz")):
        with np.load(path) as data:
            if data.files:
                found[split_of(int(path.stem))].append({name: data[name] for name in data.files})
                numbers[split_of(int(path.stem))].append(int(path.stem))
    for split, rooms in found.items():
        if rooms:
            write(output / split, joined(rooms), {"rooms": numbers[split], "seed": seed})
            print(split, json.loads((output / split / "what.json").read_text())["counts"])


if __name__ == "__main__":
    raise SystemExit(main())
