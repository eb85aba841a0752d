"""What a job says of hands: ``left=Table``, ``right=Cup:40-90``, ``left=Table#12``."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ..errors import UsageError

_TEXT = re.compile(r"(left|right)=(.+?)(?:#(\d+))?(?::(-?\d+)-(-?\d+))?", re.DOTALL)


@dataclass(frozen=True)
class HandRequest:
    """A hand on a target. side: "left" or "right". target: name of an object. vertex: its index, or None for where the
    surface is nearest. first, last: frames of the scene; None for those of the rest."""

    side: str
    target: str
    vertex: int | None = None
    first: int | None = None
    last: int | None = None


def parse(text: str) -> HandRequest:
    """Return the request of SIDE=NAME[#VERTEX][:FIRST-LAST]. Raise UsageError for any other text."""
    found = _TEXT.fullmatch(text) if isinstance(text, str) else None
    if found is None:
        raise UsageError(
            f"--hand cannot be '{text}'; write left=NAME or right=NAME, and :FIRST-LAST for frames."
        )
    side, target, *numbers = found.groups()
    vertex, first, last = (None if number is None else int(number) for number in numbers)
    if first is not None and last < first:
        raise UsageError(f"--hand has frames {first} to {last}, which are none.")
    return HandRequest(side, target, vertex, first, last)
