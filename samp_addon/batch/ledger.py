"""Which jobs of a jobs file are done, so that a second run continues where the first one ended."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ..errors import SampError
from .order import Order
from .saved_takes import SavedTakes


@dataclass
class Ledger:
    """The done jobs: one JSON object a line, in a file beside the jobs file."""

    path: Path
    entries: dict[str, dict] = field(default_factory=dict)

    @classmethod
    def beside(cls, jobs: Path) -> Ledger:
        """Return the ledger of a jobs file, `FILE.done`. A line cut off by a kill is skipped."""
        ledger = cls(jobs.with_name(jobs.name + ".done"))
        if ledger.path.is_file():
            for line in ledger.path.read_text(encoding="utf-8").splitlines():
                try:
                    entry = json.loads(line)
                    ledger.entries[entry["key"]] = entry
                except (json.JSONDecodeError, KeyError, TypeError):
                    continue
        return ledger

    def recall(self, order: Order) -> list[dict] | None:
        """Return the report's variants of a job that is done and whose files are still there, else None."""
        entry = self.entries.get(fingerprint(order))
        if entry is None or not all(Path(name).is_file() for name in entry["files"]):
            return None
        return entry["variants"]

    def saved(self, order: Order) -> SavedTakes:
        """Return the saved takes of a job that is not done yet, `FILE.takes/`."""
        folder = self.path.with_name(self.path.name.removesuffix(".done") + ".takes")
        return SavedTakes(folder, fingerprint(order)[:16])

    def record(self, order: Order, variants: Sequence[dict], files: Sequence[Path]) -> None:
        """Record that a job is done. Raise SampError where the ledger cannot be written."""
        key = fingerprint(order)
        names = [str(path.absolute()) for path in files]
        self.entries[key] = {"key": key, "files": names, "variants": list(variants)}
        try:
            # A line that a kill has cut off must not swallow this one.
            torn = self.path.is_file() and not self.path.read_bytes().endswith(b"\n")
            with self.path.open("a", encoding="utf-8") as file:
                file.write(("\n" if torn else "") + json.dumps(self.entries[key]) + "\n")
        except OSError as error:
            raise SampError(
                f"'{self.path}' cannot be written ({error}), so a second run would do this job again."
            ) from error


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
