"""What is slow to begin with, kept between runs: clips in one posture, walks by pose, pieces with their fields."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

Thing = TypeVar("Thing")


def kept(folder: Path | None, name: str, make: Callable[[], Thing]) -> Thing:
    """What ``make`` returns, from the folder's file of this name if there is one, else made and written there."""
    if folder is None:
        return make()
    path = folder / f"{name}.pickle"
    if path.exists():
        return pickle.loads(path.read_bytes())
    thing = make()
    keep(folder, name, thing)
    return thing


def keep(folder: Path | None, name: str, thing: object) -> None:
    """Writes a thing for later runs; nothing without a folder."""
    if folder is None:
        return
    folder.mkdir(parents=True, exist_ok=True)
    partial = folder / f"{name}.partial"
    partial.write_bytes(pickle.dumps(thing, protocol=pickle.HIGHEST_PROTOCOL))
    partial.replace(folder / f"{name}.pickle")
