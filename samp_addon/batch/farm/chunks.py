"""Chunks of lines, as tasks of an engine that runs Python functions in other processes."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from .selection import Selection


@dataclass(frozen=True)
class Chunk:
    """Lines of a jobs file that one task bakes. count: how many of them are not empty."""

    first: int
    last: int
    count: int

    @property
    def name(self) -> str:
        """The lines, FIRST-LAST."""
        return f"{self.first}-{self.last}"


@dataclass(frozen=True)
class Work:
    """What all chunks have in common.

    options: parsed options of the command line, with `jobs`. folder: where relative names begin. reports: folder for
    the chunks' reports; empty for none.
    """

    options: Mapping[str, Any]
    folder: str
    reports: str = ""


def chunks(lines: Iterable[int], size: int) -> list[Chunk]:
    """Return chunks of `size` lines (the last one may have fewer). lines: numbers of the lines, in order."""
    numbers = list(lines)
    pieces = [numbers[begin : begin + size] for begin in range(0, len(numbers), size)]
    return [Chunk(piece[0], piece[-1], len(piece)) for piece in pieces]


def bake_chunk(work: Work, chunk: Chunk, tools: object = None) -> int:
    """Bake the lines of a chunk in this process; return how many of them failed.

    tools: see many.bake_lines. Raise UsageError where the options cannot be used.
    """
    _forget_blender_of_the_parent()
    # Imported by the thread that uses it: Blender takes that for its main thread.
    from .. import many
    from ..console import Console

    os.chdir(work.folder)
    options = dict(work.options) | {"lines": Selection(span=(chunk.first, chunk.last))}
    if work.reports:
        options["report"] = os.path.join(work.reports, f"{chunk.name}.json")
    return many.bake_lines(options, tools, Console(silent=True)).failed


def _forget_blender_of_the_parent() -> None:
    """Take the folders that bpy has added to the module path of another process off that of this one.

    A process that was started by one with bpy inherits its path, and would import the scripts of bpy in its place.
    """
    if "bpy" not in sys.modules:
        inner = os.path.join("bpy", "__init__.py")
        foreign = os.path.join("scripts", "modules")
        sys.path[:] = [
            path
            for path in sys.path
            if not (path.endswith(foreign) and os.path.isfile(os.path.join(path, inner)))
        ]
