"""Cache slow preparations between runs: clips in the neutral posture, walks by pose, pieces with their fields."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

Thing = TypeVar("Thing")


def kept(folder: Path | None, name: str, make: Callable[[], Thing]) -> Thing:
    """Return the cached result of ``make`` from the folder, or call it and store its result there."""
    if folder is None:
        return make()
    path = folder / f"{name}.pickle"
    if path.exists():
        return pickle.loads(path.read_bytes())
    thing = make()
    keep(folder, name, thing)
    return thing


def keep(folder: Path | None, name: str, thing: object) -> None:
    """Store an object for later runs; without a folder, do nothing."""
    if folder is None:
        return
    folder.mkdir(parents=True, exist_ok=True)
    partial = folder / f"{name}.partial"
    partial.write_bytes(pickle.dumps(thing, protocol=pickle.HIGHEST_PROTOCOL))
    partial.replace(folder / f"{name}.pickle")
