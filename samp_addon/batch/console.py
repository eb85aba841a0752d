"""Output of the batch: human-readable lines, and progress lines for render-farm managers."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass

LONGEST_LINE = 600
"""Characters of a line on standard error."""

FORMATS = ("openjd",)
"""Render-farm formats of progress: that of Open Job Description."""


def _print(text: str) -> None:
    sys.stdout.write(text)
    sys.stdout.flush()


@dataclass(frozen=True)
class Console:
    """Standard output and standard error of the batch.

    farm: one of FORMATS, in addition to the human-readable lines. silent: print nothing.
    """

    farm: str | None = None
    silent: bool = False

    def say(self, text: str, write: Callable[[str], object] = _print) -> None:
        """Print a line on standard output. write: writes to it where it is redirected."""
        if not self.silent:
            write(f"bake: {printable(text)}\n")

    def complain(self, text: str) -> None:
        """Print one line on standard error, however many the text has."""
        line = " ".join(text.split())
        line = line if len(line) <= LONGEST_LINE else line[:LONGEST_LINE] + " ..."
        if not self.silent:
            print(f"bake: {printable(line)}", file=sys.stderr, flush=True)

    def advance(self, share: float, status: str, write: Callable[[str], object] = _print) -> None:
        """Report the progress, 0 to 1, and the current step to a farm's manager."""
        if self.farm == "openjd":
            write(f"openjd_progress: {100 * share:.1f}\nopenjd_status: {_one_line(status)}\n")

    def fail(self, reason: str) -> None:
        """Report the reason for a failed run to a farm's manager."""
        if self.farm == "openjd":
            _print(f"openjd_fail: {_one_line(reason)}\n")


def counted(count: int, noun: str) -> str:
    """Return a number with its noun: 1 take, 2 takes."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def printable(text: str) -> str:
    """Return the text without what no encoding has, such as half a surrogate pair from a JSON string."""
    return text.encode("utf-8", "replace").decode("utf-8")


def _one_line(text: str) -> str:
    return printable(" ".join(text.split())[:LONGEST_LINE])
