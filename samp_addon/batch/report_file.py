"""The report on disk: written whole, by one run."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..atomic_file import atomic_write
from ..blender.takes import reporting
from ..errors import SampError, UsageError
from . import build
from .farm.selection import Selection

SHARE_OF_TIME = 0.05
"""Share of a run's time that is spent on writing reports of what is done so far, at most."""


def write(path: Path | None, content: Mapping[str, Any]) -> None:
    """Write a report, whole or not at all. path: None writes none. Raise SampError."""
    if path is None:
        return
    try:
        with atomic_write(path) as part:
            part.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    except OSError as error:
        raise SampError(
            f"The report '{path}' cannot be written ({error.strerror}); choose another --report."
        ) from error


class ReportFile:
    """The report of a run over a jobs file, written again as the run goes on.

    variants, errors, repetitions: the entries so far. Raise UsageError where the file is the report of another part of
    the same jobs file, which this run would write over.
    """

    def __init__(self, path: Path | None, selection: Selection) -> None:
        self.variants: list[dict] = []
        self.errors: list[dict] = []
        self.repetitions: list[dict] = []
        self._path, self._selection = path, selection
        self._cost, self._written = 0.0, float("-inf")
        if path is not None and selection.name:
            self._claim(path)

    def content(self) -> dict[str, Any]:
        """Return the report of what is done so far."""
        made = reporting.report(self.variants, self.errors) | {"builds": [build.build()]}
        if self._selection.name:
            made["selection"] = self._selection.name
        return made | ({"repetitions": self.repetitions} if self.repetitions else {})

    def update(self, last: bool = False) -> None:
        """Write the report if the last time is long enough ago, or if this is the last time. Raise SampError."""
        begun = time.monotonic()
        if last or self._cost <= SHARE_OF_TIME * (begun - self._written):
            write(self._path, self.content())
            self._written = time.monotonic()
            self._cost = self._written - begun

    def _claim(self, path: Path) -> None:
        """Create the file, so that another part that begins at the same time finds it."""
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            file = os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY)
        except FileExistsError:
            for _ in range(10):
                other = _selection_of(path)
                if other is not None:
                    break
                time.sleep(0.1)  # the other part may have created it and not written it yet
            if other not in (None, "", self._selection.name):
                raise UsageError(
                    f"'{path}' is the report of {other}; name another --report for {self._selection.name}."
                ) from None
            return
        except OSError as error:
            raise UsageError(
                f"The report '{path}' cannot be written ({error.strerror}); choose another --report."
            ) from error
        with os.fdopen(file, "w", encoding="utf-8") as opened:
            opened.write(json.dumps(self.content(), indent=1) + "\n")


def _selection_of(path: Path) -> str | None:
    """Return which lines an existing report is about; None where it cannot be read."""
    try:
        return str(json.loads(path.read_text(encoding="utf-8")).get("selection", ""))
    except (OSError, ValueError, AttributeError, RecursionError):
        return None
