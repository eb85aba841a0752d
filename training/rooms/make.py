"""Generate the corpus of furnished rooms with people.

python -m samp_blender.training.rooms.make --rooms 300 --seed 0 --output cache/rooms --mocap FOLDER --furniture FOLDER

An interrupted run continues where it stopped. The result depends only on the options, including the seed.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import pickle
import shutil
import time
import traceback
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ..furniture.library import DEFAULT_FOLDER
from .corpus import store, windows
from .corpus.room_builder import RoomBuilder, entry
from .episodes import bank as banks
from .episodes.search import Search
from .layout import stock
from .uses.composed import Composed
from .uses.fitted_set import FittedSet
from .uses.use import Uses

LISTED = 15  # rooms between two updates of lists and manifest
TEST_SHARE = 5  # every fifth room is a test room
PICTURES = {"train": 12_000, "test": 2_000}
DEFAULT_MOCAP = DEFAULT_FOLDER.parent / "mocap"
_room_builder: RoomBuilder | None = None


def split_of(number: int) -> str:
    """Return the split to which a room belongs."""
    return "test" if number % TEST_SHARE == TEST_SHARE - 1 else "train"


def pictures_of(split: str, rooms: int, share: float) -> int:
    """Return the number of pictures of each room of a split, for PICTURES in total, times a share."""
    mine = max(sum(split_of(k) == split for k in range(rooms)), 1)
    return round(share * -(-PICTURES[split] // mine))


def room_builder(options: argparse.Namespace) -> RoomBuilder:
    """Return the resources of all rooms; clips are read once and cached next to the rooms."""
    cache = Path(options.output)
    cache.mkdir(parents=True, exist_ok=True)
    kept = cache / "clips.pkl"
    if kept.exists():
        bank, uses = pickle.loads(kept.read_bytes())
    else:
        bank, clips = banks.load(options.mocap)
        uses = Composed(clips, cache / "uses")
        part = kept.with_suffix(f".{os.getpid()}")
        part.write_bytes(pickle.dumps((bank, uses)))
        part.replace(kept)
    seats = None
    if options.uses == "fitted":
        uses = _fitted(bank, uses, cache)
    if options.fitted is not None:
        uses = _fitted_set(options.fitted, bank, uses, cache)
        seats = uses.used_items()
    stocks = {
        name: stock.build(options.furniture, name == "test", options.seed, seats if name == "train" else None)
        for name in store.SPLITS
    }
    return RoomBuilder(cache, options.seed, stocks, bank, Search(bank), uses, options.episodes)


def _fitted(bank: banks.Bank, composed: Composed, cache: Path) -> Uses:
    """Return sits and lies fitted to each piece, instead of the composed ones."""
    from ..composition.stitch import WalkIndex
    from .uses.fitted import Fitted

    firsts = np.flatnonzero(np.diff(bank.clip, prepend=-1))
    clip = min((event.clip for event in composed.events), key=len)
    return Fitted(composed, WalkIndex([clip], history=2), bank.names, firsts, cache / "fitted")


def _fitted_set(paths: list[Path], bank: banks.Bank, others: Uses, cache: Path) -> FittedSet:
    """Return sits and lies from files for training rooms, and ``others`` for the pieces of test rooms."""
    kept = cache / "fitted.pkl"
    if not kept.exists():
        made = FittedSet(paths, bank)
        part = kept.with_suffix(f".{os.getpid()}")
        part.write_bytes(pickle.dumps(made))
        part.replace(kept)
    made = pickle.loads(kept.read_bytes())
    made.others = others
    return made


def _one(task: tuple[int, str, int]) -> dict | None:
    """Build one room; return its entry of the manifest, or None after printing the error, so that others continue."""
    began = time.time()
    try:
        made = _room_builder.make(*task)
    except Exception:
        print(f"room {task[0]} {task[1]} failed:\n{traceback.format_exc()}", flush=True)
        return None
    print(
        f"room {made['number']} {made['split']} {made['kind']}: {made['episodes']} episodes, {made['sits']} sits, "
        f"{made['lies']} lies, {made['pictures']} pictures in {time.time() - began:.0f} s",
        flush=True,
    )
    return made


def main(arguments: list[str] | None = None) -> int:
    """Run the command; return its exit status."""
    global _room_builder  # noqa: PLW0603 - shared with forked workers
    parser = argparse.ArgumentParser(prog="make", description=__doc__.splitlines()[0])
    parser.add_argument("--rooms", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path, default=Path("cache/rooms"))
    parser.add_argument(
        "--mocap", type=Path, default=DEFAULT_MOCAP, help="folder of the prepared sets of clips"
    )
    parser.add_argument("--furniture", type=Path, default=DEFAULT_FOLDER)
    parser.add_argument(
        "--uses",
        choices=("composed", "fitted"),
        default="composed",
        help="source of the sits and lies on furniture",
    )
    parser.add_argument(
        "--fitted",
        type=Path,
        nargs="+",
        help="training sets of fitted sits and lies; their pieces furnish training rooms",
    )
    parser.add_argument("--episodes", type=int, default=40, help="episodes in each room")
    parser.add_argument("--pictures", type=float, default=1.0, help="share of the pictures to render")
    parser.add_argument(
        "--first", type=int, default=0, help="number of the first room, to build a part of the corpus"
    )
    parser.add_argument("--last", type=int, help="number after that of the last room")
    parser.add_argument("--split", choices=store.SPLITS, help="build only the rooms of one split")
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args(arguments)
    if not shutil.os.path.isdir(options.mocap):
        parser.error(f"{options.mocap} does not exist; docs/training.md lists the sources of the clips")
    began = time.time()
    _room_builder = room_builder(options)
    numbers = range(options.first, options.rooms if options.last is None else options.last)
    numbers = [k for k in numbers if options.split in (None, split_of(k))]
    tasks = [(k, split_of(k), pictures_of(split_of(k), options.rooms, options.pictures)) for k in numbers]
    failed = 0
    for done, made in enumerate(_rooms(tasks, options.workers), 1):
        failed += made is None
        if done % LISTED == 0:
            finish(options)
    rooms, counts, hours = finish(options)
    print(f"{rooms} rooms, {hours:.2f} hours, {counts}, {time.time() - began:.0f} s, {failed} failed")
    return int(failed > 0)


def _rooms(tasks: list[tuple[int, str, int]], workers: int) -> Iterator[dict | None]:
    if workers > 1:
        with multiprocessing.get_context("fork").Pool(workers) as pool:
            yield from pool.imap_unordered(_one, tasks)
    else:
        yield from map(_one, tasks)


def finish(options: argparse.Namespace) -> tuple[int, dict[str, int], float]:
    """Write lists and manifest of the finished rooms; return their number, the lengths of the lists, and hours."""
    every = (entry(options.output, k, split_of(k)) for k in range(options.rooms))
    rooms = [room for room in every if room is not None]
    counts = windows.write(options.output, rooms, options.seed)
    hours = sum(r["frames"] for r in rooms) / 108_000
    manifest = {
        "version": store.VERSION, "seed": options.seed, "fps": 30, "hours": hours, "counts": counts,
        "quaternion_unit": store.QUATERNION, "depth_unit": store.DEPTH_UNIT, "normal_unit": store.NORMAL_UNIT,
        "clips": _room_builder.bank.names, "rooms": rooms,
    }  # fmt: skip
    store.write_json(options.output / "manifest.json", manifest)
    return len(rooms), counts, hours


if __name__ == "__main__":
    raise SystemExit(main())
