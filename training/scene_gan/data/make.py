"""Make the data set of Scene GAN from a corpus of rooms.

python -m samp_blender.training.scene_gan.data.make --corpus cache/rooms --output cache/scene_gan

One folder for each split: arrays as .npy files that are memory-mapped, and what.json. Rooms that have no pictures yet
are left out, so that a corpus in the making can be used.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import numpy as np

from ...rooms.corpus import store
from . import heights, room_pictures, room_windows
from .units import ROOT_UNIT

WINDOWS = 250  # of a room, at random
PAIRS = 12  # windows of a picture
PER_PICTURE = ("colour", "depth", "classes", "lens", "extrinsics")
PER_WINDOW = ("root", "rotations", "labels")


def of_room(
    data: store.RoomData, windows: int, pairs: int, rng: np.random.Generator
) -> dict[str, np.ndarray] | None:
    """Return a room's arrays, indices counted within the room; None where no window is in view of a picture."""
    pictures = room_pictures.of_room(data)
    if "colour" not in pictures:
        return None
    wanted = np.column_stack([pictures["episode"], pictures["frame"]])
    chosen = room_windows.of_room(data, windows, rng, wanted)
    motion = room_windows.motion(data, chosen)
    joints = room_windows.first_joints(motion, chosen["episode"])
    rows = []
    for number in range(len(pictures["colour"])):
        lens = pictures["lens"][number]
        camera = room_pictures.camera_of(np.eye(3) * lens[0], pictures["extrinsics"][number], 1)
        seen = np.flatnonzero(room_windows.in_view(joints, camera, pictures["depth"][number]))
        rows += [(number, window) for window in np.sort(rng.permutation(seen)[:pairs])]
    if not rows:
        return None
    # Only windows that are used are kept.
    table = np.array(rows, np.int32)
    used, table[:, 1] = np.unique(table[:, 1], return_inverse=True)
    heights_of, corner = heights.grid(data.room.triangles)
    return {
        **{name: pictures[name] for name in PER_PICTURE},
        **{name: motion[name][used] for name in PER_WINDOW},
        "root": np.round(motion["root"][used] / ROOT_UNIT).astype(np.int16),
        "body": chosen["episode"][used].astype(np.int32),
        "rest": motion["rest"],
        "pairs": table,
        "heights": heights_of[None],
        "corners": corner[None].astype(np.float32),
    }


def joined(rooms: list[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Return the arrays of several rooms in a row, indices counted over all of them; room_of_picture is added."""
    out = {
        name: np.concatenate([room[name] for room in rooms])
        for name in rooms[0]
        if name not in ("pairs", "body")
    }
    counts = lambda name: np.cumsum([0, *(len(room[name]) for room in rooms)])[:-1]
    pictures, windows, bodies = counts("colour"), counts("root"), counts("rest")
    out["pairs"] = np.concatenate(
        [r["pairs"] + [p, w] for r, p, w in zip(rooms, pictures, windows, strict=True)]
    )
    out["pairs"] = out["pairs"].astype(np.int32)
    out["body"] = np.concatenate([r["body"] + b for r, b in zip(rooms, bodies, strict=True)]).astype(np.int32)
    out["room_of_picture"] = np.repeat(np.arange(len(rooms)), [len(r["colour"]) for r in rooms]).astype(
        np.int32
    )
    return out


def write(folder: Path, arrays: dict[str, np.ndarray], notes: dict) -> None:
    """Write a split of the data set."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, values in arrays.items():
        np.save(folder / f"{name}.npy", values)
    counts = {name: len(arrays[name]) for name in ("colour", "root", "pairs", "heights") if name in arrays}
    store.write_json(folder / "what.json", notes | {"counts": counts})


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--corpus", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--windows", type=int, default=WINDOWS, help="of a room")
    parser.add_argument("--pairs", type=int, default=PAIRS, help="windows of a picture")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    began, found = time.time(), {name: [] for name in store.SPLITS}
    numbers: dict[str, list[int]] = {name: [] for name in store.SPLITS}
    from ...rooms.make import split_of

    for folder in sorted((options.corpus / "rooms").iterdir()):
        if not all(store.has_stage(folder, stage) for stage in ("motion", "pictures")):
            continue
        number = int(folder.name)
        rng = np.random.default_rng([options.seed, number])
        room = of_room(store.RoomData(folder), options.windows, options.pairs, rng)
        if room is not None:
            found[split_of(number)].append(room)
            numbers[split_of(number)].append(number)
            print(f"room {number}: {len(room['colour'])} pictures, {len(room['root'])} windows, "
                  f"{len(room['pairs'])} pairs, {time.time() - began:.0f} s", flush=True)  # fmt: skip
    for split, rooms in found.items():
        if rooms:
            write(options.output / split, joined(rooms), {"rooms": numbers[split], "seed": options.seed})
            print(split, json.loads((options.output / split / "what.json").read_text())["counts"])
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
