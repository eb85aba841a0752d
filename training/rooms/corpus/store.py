"""Storage of the corpus: folders of rooms, memory-mapped arrays, the manifest. All files are written atomically."""

from __future__ import annotations

import json
import os
import shutil
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np

from ....samp_addon import rotation
from ....samp_addon.body import human
from ....samp_addon.motion import Motion
from ..episodes import bodies
from ..layout.room import Room

VERSION = 1
QUATERNION = 32767  # unit of rotations stored as int16
SPLITS = ("train", "test")
DEPTH_UNIT = 0.001  # metres per unit of depth stored as uint16
NORMAL_UNIT = 127  # unit of normals stored as int8


def write_stage(folder: Path, stage: str, arrays: dict[str, np.ndarray], notes: dict | None = None) -> None:
    """Write arrays as NAME.npy and notes.json into folder/stage, atomically for the whole stage."""
    part = folder / f".{stage}.{os.getpid()}"
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir(parents=True)
    for name, array in arrays.items():
        np.save(part / f"{name}.npy", array)
    (part / "notes.json").write_text(json.dumps(notes or {}))
    final = folder / stage
    shutil.rmtree(final, ignore_errors=True)
    part.replace(final)


def write_json(path: Path, value: object) -> None:
    """Write a JSON file atomically."""
    part = path.with_suffix(f".{os.getpid()}")
    part.write_text(json.dumps(value, indent=1))
    part.replace(path)


def has_stage(folder: Path, stage: str) -> bool:
    """Return whether a stage is finished."""
    return (folder / stage / "notes.json").exists()


def notes(folder: Path, stage: str) -> dict:
    """Return the notes of a stage."""
    return json.loads((folder / stage / "notes.json").read_text())


def room_folder(cache: Path, number: int) -> Path:
    """Return the folder of a room."""
    return Path(cache) / "rooms" / f"{number:04d}"


class RoomData:
    """One room of a corpus; arrays are memory-mapped, see docs/training.md for their contents."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @cached_property
    def room(self) -> Room:
        """The room's layout."""
        return Room.load(self.folder / "layout" / "room.npz")

    @lru_cache(maxsize=64)  # noqa: B019
    def array(self, stage: str, name: str) -> np.ndarray:
        """Return an array of a stage: motion, cloud or pictures."""
        return np.load(self.folder / stage / f"{name}.npy", mmap_mode="r")

    @property
    def bounds(self) -> np.ndarray:
        """First frames of the episodes and the end of the last one (E + 1,)."""
        return self.array("motion", "bounds")

    def build(self, episode: int) -> bodies.Build:
        """Return the build of an episode's body."""
        return bodies.of(np.array(self.array("motion", "shapes")[episode], np.float64))

    def motion(self, episode: int, start: int = 0, count: int | None = None) -> Motion:
        """Return ``count`` frames of an episode from ``start`` on, as a Motion on its own body."""
        first, last = (int(v) for v in self.bounds[episode : episode + 2])
        part = slice(first + start, last if count is None else min(first + start + count, last))
        quats = rotation.normalise(self.array("motion", "rotations")[part].astype(np.float64) / QUATERNION)
        return Motion(
            self.array("motion", "root")[part].astype(np.float64), quats,
            contacts=self.array("motion", "contacts")[part].astype(np.float64),
            rest_joints=self.build(episode).body.joints,
        )  # fmt: skip

    def body(self, episode: int) -> human.Human:
        """Return the body of an episode with its skin."""
        return self.build(episode).body


class Corpus:
    """A finished corpus, for training: rooms by number, lists of windows."""

    def __init__(self, cache: Path) -> None:
        self.cache = Path(cache)
        self.manifest = json.loads((self.cache / "manifest.json").read_text())

    @lru_cache(maxsize=512)  # noqa: B019
    def room(self, number: int) -> RoomData:
        """Return one room, cached."""
        return RoomData(room_folder(self.cache, number))

    def windows(self, kind: str, split: str) -> np.ndarray:
        """Return the rows of a list, see windows.py; kind: "windows", "bodies" or "pictures"."""
        return np.load(self.cache / f"{kind}_{split}.npy", mmap_mode="r")

    def rooms(self, split: str) -> list[int]:
        """Return the numbers of the rooms of a split."""
        return [room["number"] for room in self.manifest["rooms"] if room["split"] == split]
