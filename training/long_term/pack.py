"""Pack a corpus of rooms into one compact file to train the long-term method.

python -m samp_blender.training.long_term.pack --corpus cache/rooms --split train --output long_term.bin --mib 36

As many whole episodes as fit are stored, evenly over the rooms; windows of all lengths refer to them, so that shared
frames are stored once. Positions are rounded to 0.1 mm, rotations to 0.014 degrees, points of clouds to a millimetre.
"""

from __future__ import annotations

import argparse
import io
import lzma
import time
from pathlib import Path

import numpy as np

from ...samp_addon import rotation
from ...samp_addon.errors import SampError
from ...samp_addon.methods.long_term import way
from ...samp_addon.scene.navmesh import navmesh
from .. import planes
from ..rooms.corpus import store

STEP = 1e-4  # resolution of positions, metres
UNIT = 8191  # unit of rotations
CLOUD_STEP = 1e-3  # resolution of points, metres
POINTS = 8000  # points of a room's cloud
LENGTHS = (16, 24, 32, 40, 50, 61, 75, 90)  # frames of windows
PAPER = 61
APART = 0.5  # metres between the ends of the paper's windows
BYTES = 62  # approximate size of a compressed frame
CONTACTS = 5


def read_rooms(corpus: store.Corpus, split: str, episodes: int, windows: int, seed: int) -> dict:
    """Return the arrays of a pack.

    episodes: largest number for each room. windows: largest number for each length and room.
    """
    rng = np.random.default_rng([seed, store.SPLITS.index(split)])
    parts: dict[str, list] = {name: [] for name in ("root", "rotations", "labels", "contacts", "shapes", "lengths",
                                                     "rooms", "numbers", "points", "normals", "classes", "windows",
                                                     "paths")}  # fmt: skip
    for row, number in enumerate(corpus.rooms(split)):
        data = corpus.room(number)
        chosen = rng.permutation(len(data.bounds) - 1)[:episodes]
        first_episode = len(parts["lengths"])
        for episode in np.sort(chosen):
            first, last = (int(v) for v in data.bounds[episode : episode + 2])
            for name in ("root", "rotations", "labels", "contacts"):
                parts[name].append(np.array(data.array("motion", name)[first:last]))
            parts["shapes"].append(np.array(data.array("motion", "shapes")[episode]))
            parts["lengths"].append(last - first)
            parts["rooms"].append(row)
        keep = rng.permutation(len(data.array("cloud", "points")))[:POINTS]
        for name in ("points", "normals", "classes"):
            parts[name].append(np.array(data.array("cloud", name))[keep])
        parts["numbers"].append(number)
        found = _windows(data, parts["root"][first_episode:], first_episode, windows, rng)
        parts["windows"].append(found[0])
        parts["paths"].append(found[1])
        print(f"room {number}: {len(chosen)} episodes, {len(found[0])} windows", flush=True)
    frames = ("root", "rotations", "labels", "contacts", "windows", "paths")
    joined = {name: np.concatenate(parts[name]) for name in frames}
    stacked = {name: np.stack(parts[name]) for name in ("shapes", "points", "normals", "classes")}
    counts = {name: np.array(parts[name], np.int32) for name in ("lengths", "rooms", "numbers")}
    return joined | stacked | counts


def _windows(
    data: store.RoomData, roots: list[np.ndarray], first: int, most: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Return windows (W, 3) of episode, first frame and length, and their paths (W, 16, 2), x and z in metres.

    Three of four windows are locomotion; the others are standing, sitting down, resting or rising.
    """
    mesh = navmesh.build(data.room.triangles)
    rows, lines = [], []
    for length in LENGTHS:
        each = [
            np.column_stack([np.full(n, k), np.arange(n)])
            for k, n in enumerate(max(len(root) - length, 0) for root in roots)
        ]
        every = np.concatenate(each) if each else np.zeros((0, 2), int)
        if not len(every):
            continue
        order = every[rng.permutation(len(every))]
        far = np.array(
            [np.linalg.norm((roots[k][f + length - 1] - roots[k][f])[[0, 2]]) for k, f in order[: 8 * most]]
        )
        least = APART * min(length / PAPER, 1.0)
        some = order[: 8 * most]
        moving, still = some[far >= least], some[far < least]
        wanted = (
            moving[:most]
            if length == PAPER
            else np.concatenate([moving[: most * 3 // 4], still[: most // 4]])
        )
        for k, f in wanted:
            line = _path(mesh, roots[k][f], roots[k][f + length - 1])
            rows.append((first + k, f, length))
            lines.append(line)
    return np.array(rows, np.int32).reshape(-1, 3), np.array(lines, np.float32).reshape(-1, way.POINTS, 2)


def _path(mesh: navmesh.NavMesh, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the path (16, 2), metres, between two bodies, straight where there is none on the navmesh."""
    try:
        return way.between(mesh, start, end)[:, [0, 2]]
    except SampError:
        return way.resampled(np.array([start, end]))[:, [0, 2]]


def write(raw: dict[str, np.ndarray], path: Path) -> None:
    """Write the arrays of a pack."""
    quats = rotation.normalise(raw["rotations"].astype(np.float64))
    signed = np.where(quats[..., :1] < 0, -quats, quats)[..., 1:]
    kept = {
        name: raw[name] for name in ("labels", "lengths", "rooms", "numbers", "windows", "classes", "normals")
    }
    kept["joints"] = planes.encoded(
        np.round(signed * UNIT).astype(np.int16).reshape(len(quats), -1).view(np.uint16)
    )
    kept["way"] = planes.encoded(
        np.round(raw["root"].astype(np.float64) / STEP).astype(np.int32).view(np.uint32)
    )
    kept["contacts"] = np.packbits(raw["contacts"].astype(bool), axis=1)
    kept["shapes"] = raw["shapes"].astype(np.float16)
    kept["points"] = np.round(raw["points"] / CLOUD_STEP).astype(np.int16)
    kept["paths"] = np.round(raw["paths"] / CLOUD_STEP).astype(np.int16)
    held = io.BytesIO()
    np.savez(held, **kept)
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    part.write_bytes(lzma.compress(held.getvalue(), preset=1))
    part.replace(path)


def read(path: Path) -> dict[str, np.ndarray]:
    """Return the arrays of a pack.

    root (N, 3), rotations (N, 22, 4) float32, labels (N,), contacts (N, 5) of all frames; lengths, rooms (E,) and
    shapes (E, 8) of the episodes; points, normals (R, P, 3), classes (R, P) and numbers (R,) of the rooms; windows
    (W, 3) of episode, first frame and length, and paths (W, 16, 2).
    """
    with np.load(io.BytesIO(lzma.decompress(Path(path).read_bytes()))) as data:
        raw = {name: data[name] for name in data.files}
    count = int(raw["lengths"].sum())
    part = planes.decoded(raw.pop("joints"), count, np.int16).reshape(count, -1, 3).astype(np.float32) / UNIT
    w = np.sqrt(np.maximum(1 - np.square(part).sum(-1, keepdims=True), 0))
    raw["rotations"] = np.concatenate([w, part], -1)
    raw["root"] = (planes.decoded(raw.pop("way"), count, np.int32) * STEP).astype(np.float32)
    raw["contacts"] = np.unpackbits(raw["contacts"], axis=1)[:, :CONTACTS]
    raw["shapes"] = raw["shapes"].astype(np.float32)
    raw["points"] = raw["points"].astype(np.float32) * CLOUD_STEP
    raw["normals"] = raw["normals"].astype(np.float32) / store.NORMAL_UNIT
    raw["paths"] = raw["paths"].astype(np.float32) * CLOUD_STEP
    return raw


def fitting_episodes(corpus: store.Corpus, split: str, mib: float) -> int:
    """Return the number of episodes of each room that fit into a file of ``mib`` MiB."""
    rooms = [room for room in corpus.manifest["rooms"] if room["split"] == split]
    frames = sum(room["frames"] for room in rooms) / max(sum(room["episodes"] for room in rooms), 1)
    left = mib * 2**20 - len(rooms) * POINTS * 8
    return max(int(left / BYTES / max(frames, 1) / max(len(rooms), 1)), 1)


def main(arguments: list[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--corpus", type=Path, required=True)
    parser.add_argument("--split", choices=store.SPLITS, default="train")
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--mib", type=float, default=36.0, help="approximate size of the file")
    parser.add_argument("--windows", type=int, default=8000, help="windows of each length, over all rooms")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    began = time.time()
    corpus = store.Corpus(options.corpus)
    rooms = max(len(corpus.rooms(options.split)), 1)
    episodes = fitting_episodes(corpus, options.split, options.mib)
    raw = read_rooms(corpus, options.split, episodes, -(-options.windows // rooms), options.seed)
    write(raw, options.output)
    print(
        f"{len(raw['root'])} frames, {len(raw['windows'])} windows, {len(raw['numbers'])} rooms, "
        f"{options.output.stat().st_size / 2**20:.1f} MiB, {time.time() - began:.0f} s"
    )


if __name__ == "__main__":
    main()
