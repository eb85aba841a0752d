"""Which line of a jobs file writes which files. The lines of other parts count as well."""

from __future__ import annotations

import json
import os
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ...errors import SampError
from ..order import PATHS, Order

Line = tuple[int, str | SampError]
_Key = tuple[str, ...]


class Claims:
    """The files that the lines of a jobs file write; of several lines that name a file, the first one writes it.

    lines: all of the jobs file. shared: options of the command line. parse: returns the order of a line, or None
    where it cannot be done. Only lines that can collide with a line in question are parsed.
    """

    def __init__(
        self,
        lines: Sequence[Line],
        shared: Mapping[str, Any],
        opened: Path | None,
        parse: Callable[[str], Order | None],
    ) -> None:
        self._parse = parse
        self._entered: set[int] = set()
        self._writers: dict[str, list[tuple[int, str]]] = defaultdict(list)
        self._neighbours: dict[_Key, list[tuple[int, str]]] = defaultdict(list)
        self._keys: dict[int, list[_Key]] = {}
        for number, text in lines:
            self._keys[number] = [] if isinstance(text, SampError) else list(_keys(text, shared, opened))
            for key in self._keys[number]:
                self._neighbours[key].append((number, text))

    def first_line(self, number: int, made: Order) -> int:
        """Return the number of the first line that does this line's job: its own, unless it is a repetition.

        Raise SampError if an earlier line writes one of its files with other options.
        """
        self._enter(number, made)
        for key in self._keys[number]:
            for other, text in self._neighbours[key]:
                if other < number and other not in self._entered:
                    self._enter(other, self._parse(text))
        job, first = _job(made), number
        for path in written(made):
            line, other = min(self._writers[path])
            if other != job:
                raise SampError(f"'{path}' is written by line {line} already; name another file.")
            first = min(first, line)
        return first

    def _enter(self, number: int, made: Order | None) -> None:
        if number in self._entered:
            return
        self._entered.add(number)
        for path in [] if made is None else written(made):
            self._writers[path].append((number, _job(made)))


def written(made: Order) -> list[str]:
    """Return the files that an order writes, as absolute paths."""
    single = [path for path in (made.output, made.report) if path is not None]
    takes = list(made.npz_paths().values()) if made.npz is not None else []
    pictures = list(made.preview_paths().values()) if made.preview is not None else []
    if made.dataset is not None:
        takes += made.dataset_paths().values()
        pictures += (
            [folder / "cameras.json" for folder in made.frame_folders().values()] if made.frames else []
        )
    return [os.path.abspath(path) for path in (*single, *takes, *pictures)]


def _job(made: Order) -> str:
    return json.dumps(made.options(), sort_keys=True)


def _keys(text: str, shared: Mapping[str, Any], opened: Path | None) -> Iterator[_Key]:
    """Yield keys of a line without parsing its options; lines that write the same file have one in common."""
    try:
        values = json.loads(text)
    except (ValueError, RecursionError):
        return
    if not isinstance(values, dict):
        return
    found = {name: values.get(name, shared.get(name)) for name in PATHS}
    paths = {name: path for name, path in found.items() if isinstance(path, str) and "\0" not in path}
    for name in ("output", "report"):
        if name in paths:
            yield "file", os.path.abspath(paths[name])
    for name in ("npz", "preview", "dataset"):
        if name in paths:
            stem = Path(paths.get("scene") or opened or "untitled").stem
            yield name, os.path.abspath(paths[name]), stem
