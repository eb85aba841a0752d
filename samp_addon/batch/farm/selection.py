"""Which lines of a jobs file a run does: all of them, one part of them, or a range."""

from __future__ import annotations

import argparse
import re
from dataclasses import dataclass

_PART = re.compile(r"(\d{1,9})/(\d{1,9})")
_RANGE = re.compile(r"(\d{1,9})(?:-(\d{1,9}))?")
_NAME = re.compile(r"part-(\d+)-of-(\d+)|lines-(\d+)-(\d+)")


@dataclass(frozen=True)
class Selection:
    """Lines by their number in the file, which begins at 1 and counts empty lines.

    part: (I, N) with 0 <= I < N, the lines whose number is I modulo N. span: (first, last), both included. With
    neither, all lines.
    """

    part: tuple[int, int] | None = None
    span: tuple[int, int] | None = None

    def __contains__(self, number: int) -> bool:
        if self.part is not None:
            index, count = self.part
            return number % count == index
        return self.span is None or self.span[0] <= number <= self.span[1]

    @property
    def name(self) -> str:
        """The selection as part of a file's name; empty for all lines."""
        if self.part is not None:
            return "part-{}-of-{}".format(*self.part)
        return "" if self.span is None else "lines-{}-{}".format(*self.span)


def named(name: str) -> Selection | None:
    """Return the selection of a name, or None where it is no name of one."""
    if not name:
        return Selection()
    found = _NAME.fullmatch(name)
    if found is None:
        return None
    index, count, first, last = (None if text is None else int(text) for text in found.groups())
    return Selection(span=(first, last)) if index is None else Selection(part=(index, count))


def part(text: str) -> Selection:
    """Return the part I/N, for argparse. I goes from 0 to N; N is the same part as 0."""
    found = _PART.fullmatch(text)
    if found is not None:
        index, count = map(int, found.groups())
        if 0 <= index <= count and count > 0:
            return Selection(part=(index % count, count))
    raise argparse.ArgumentTypeError(f"'{text[:40]}' is no part; write I/N with I from 0 to N, such as 1/4")


def span(text: str) -> Selection:
    """Return the range FIRST-LAST, or one line, for argparse."""
    found = _RANGE.fullmatch(text)
    if found is not None:
        first = int(found[1])
        last = first if found[2] is None else int(found[2])
        if 1 <= first <= last:
            return Selection(span=(first, last))
    raise argparse.ArgumentTypeError(
        f"'{text[:40]}' is no range of lines; write FIRST-LAST, such as 1-25; the first line is 1"
    )
