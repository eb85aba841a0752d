"""Takes of an unfinished job on disk, so that a run that was killed continues with them.

One .npz for each piece of work, of arrays and text only, in a folder beside the jobs file.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...atomic_file import atomic_write
from ...methods.take import Failure, SubGoal, Take
from ...motion import Goal, Motion
from ...pipeline.cast.cast_take import CastTake
from ...refine.refinement import Refined

CLASSES = {cls.__name__: cls for cls in (Take, SubGoal, Failure, Motion, Goal, Refined, CastTake)}


@dataclass(frozen=True)
class SavedTakes:
    """The takes of one job. job: a name that changes with any of its options."""

    folder: Path
    job: str

    def load(self, piece: str) -> tuple[list[Take], list[Failure]] | None:
        """Return what this piece of the work made, or None if it is to be done. An unreadable file counts as none."""
        try:
            with np.load(self._path(piece), allow_pickle=False) as data:
                arrays = {name: data[name] for name in data.files}
            takes, failures = _decoded(json.loads(str(arrays.pop("made"))), arrays)
        except (OSError, EOFError, ValueError, KeyError, TypeError, zipfile.BadZipFile):
            return None
        return takes, failures

    def save(self, piece: str, takes: Sequence[Take], failures: Sequence[Failure]) -> None:
        """Save what a piece of the work has made. A disk that cannot take it is no reason to stop."""
        arrays: dict[str, np.ndarray] = {}
        made = json.dumps(_encoded([list(takes), list(failures)], arrays))
        try:
            with atomic_write(self._path(piece)) as part:
                np.savez(part, made=np.array(made), **arrays)
        except OSError:
            return

    def forget(self) -> None:
        """Delete all files of the job, and the folder once it is empty."""
        for path in self.folder.glob(f"{self.job}-*.npz"):
            path.unlink(missing_ok=True)
        with suppress(OSError):  # not empty, or another part was quicker
            self.folder.rmdir()

    def _path(self, piece: str) -> Path:
        return self.folder / f"{self.job}-{piece}.npz"


def _encoded(value: object, arrays: dict[str, np.ndarray]) -> Any:
    """Return a value as JSON holds it; arrays go into `arrays` and leave their name."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        name = f"array{len(arrays)}"
        arrays[name] = value
        return {"array": name}
    if is_dataclass(value):
        own = {f.name: _encoded(getattr(value, f.name), arrays) for f in fields(value)}
        return {"class": type(value).__name__, "fields": own}
    if isinstance(value, dict):
        return {"pairs": [[key, _encoded(part, arrays)] for key, part in value.items()]}
    if isinstance(value, list | tuple):
        parts = [_encoded(part, arrays) for part in value]
        return {"tuple": parts} if isinstance(value, tuple) else parts
    return value


def _decoded(stored: Any, arrays: dict[str, np.ndarray]) -> Any:
    """Return the value that `_encoded` was given. Raise KeyError or TypeError for one of another version."""
    if isinstance(stored, list):
        return [_decoded(part, arrays) for part in stored]
    if not isinstance(stored, dict):
        return stored
    if "array" in stored:
        return arrays[stored["array"]]
    if "tuple" in stored:
        return tuple(_decoded(part, arrays) for part in stored["tuple"])
    if "pairs" in stored:
        return {key: _decoded(part, arrays) for key, part in stored["pairs"]}
    values = {name: _decoded(part, arrays) for name, part in stored["fields"].items()}
    return CLASSES[stored["class"]](**values)
