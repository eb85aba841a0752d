"""Members of a cast whose methods take the other bodies over time into account, and what they are given.

They are generated one after another, since each has to know those before it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...body.balls import Track
from ...methods.method import Method
from .together import Row


def seeing(rows: Mapping[int, Row], methods: Mapping[str, Method]) -> list[int]:
    """Return the members whose first step is made by a method that needs the other bodies."""
    return [k for k, row in rows.items() if "others" in methods[row[0][0].method].needs]


def among(row: Row, bodies: Sequence[tuple[Track, int]]) -> Row:
    """Return the steps of a member with other bodies in the scene of the first one.

    bodies: each with the number of frames by which it begins later. Later steps have none, because the time at which
    they begin is not known.
    """
    (step, view), *later = row
    return [(step, replace(view, others=[late(body, frames) for body, frames in bodies])), *later]


def late(body: Track, frames: int) -> Track:
    """Return a body that is delayed by a number of frames, negative for earlier; before it begins, it has its first
    pose."""
    rows = np.clip(np.arange(max(len(body) + frames, 1)) - frames, 0, len(body) - 1)
    return replace(body, centres=body.centres[rows])
