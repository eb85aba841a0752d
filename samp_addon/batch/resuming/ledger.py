"""Which jobs of a jobs file are done, so that a second run continues where the first one ended.

Each part of a jobs file has a ledger of its own, and reads those of the parts that have lines in common with it.
"""

from __future__ import annotations

import glob
import hashlib
import json
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ...errors import SampError
from ..farm.selection import Selection, named
from ..order import Order
from .saved_takes import SavedTakes


@dataclass
class Ledger:
    """The done jobs: one JSON object a line, in a file beside the jobs file."""

    path: Path
    takes: Path
    entries: dict[str, dict] = field(default_factory=dict)

    @classmethod
    def beside(cls, jobs: Path, lines: Iterable[int] = (), selection: Selection | None = None) -> Ledger:
        """Return the ledger of some lines of a jobs file, `FILE.done` or `FILE.SELECTION.done`.

        lines: numbers of the lines that are done here; what other ledgers say of these is read as well.
        """
        own = _path(jobs, "" if selection is None else selection.name)
        ledger = cls(own, jobs.with_name(f"{jobs.name}.takes"))
        numbers = set(lines)
        for path in sorted(jobs.parent.glob(f"{glob.escape(jobs.name)}*.done")):
            other = named(path.name[len(jobs.name) : -len(".done")].removeprefix("."))
            if path != own and other is not None and any(number in other for number in numbers):
                ledger._read(path)
        ledger._read(own)
        return ledger

    def _read(self, path: Path) -> None:
        """Add the entries of a file. A line cut off by a kill is skipped."""
        if not path.is_file():
            return
        for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
            try:
                entry = json.loads(line)
                self.entries[entry["key"]] = entry
            except (json.JSONDecodeError, KeyError, TypeError):
                continue

    def recall(self, order: Order) -> list[dict] | None:
        """Return the report's variants of a job that is done and whose files are still there, else None."""
        entry = self.entries.get(fingerprint(order))
        if entry is None or not all(Path(name).is_file() for name in entry["files"]):
            return None
        return entry["variants"]

    def saved(self, order: Order) -> SavedTakes:
        """Return the saved takes of a job that is not done yet, `FILE.takes/`."""
        return SavedTakes(self.takes, fingerprint(order)[:16])

    def record(self, order: Order, variants: Sequence[dict], files: Sequence[Path]) -> None:
        """Record that a job is done. Raise SampError where the ledger cannot be written."""
        key = fingerprint(order)
        names = [str(path.absolute()) for path in files]
        self.entries[key] = {"key": key, "files": names, "variants": list(variants)}
        try:
            _append(self.path, json.dumps(self.entries[key]))
        except OSError as error:
            raise SampError(
                f"'{self.path}' cannot be written ({error}), so a second run would do this job again."
            ) from error


def _path(jobs: Path, selection: str) -> Path:
    return jobs.with_name(".".join(filter(None, (jobs.name, selection, "done"))))


def _append(path: Path, line: str) -> None:
    """Append a line in one call; one that a kill has cut off must not swallow it."""
    file = os.open(path, os.O_RDWR | os.O_APPEND | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o666)
    try:
        torn = os.lseek(file, 0, os.SEEK_END) > 0
        if torn:
            os.lseek(file, -1, os.SEEK_END)
            torn = os.read(file, 1) != b"\n"
        os.write(file, (("\n" if torn else "") + line + "\n").encode("utf-8"))
    finally:
        os.close(file)


def fingerprint(order: Order) -> str:
    """Return a name that changes with any option and with the scene's file, and when that is saved again."""
    options = order.options()
    scene = order.scene or order.opened
    if scene is not None:
        options["scene"] = str(scene.absolute())
        if scene.is_file():
            stat = scene.stat()
            options["saved"] = [stat.st_mtime_ns, stat.st_size]
    return hashlib.sha256(json.dumps(options, sort_keys=True).encode()).hexdigest()
