"""Members whose methods know where the others are at every time: they are generated one after another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...evaluation.between_bodies import Track
from ...methods.method import Method
from .together import Row


def seeing(rows: Mapping[int, Row], methods: Mapping[str, Method]) -> list[int]:
    """Return the members of these whose first step is made by such a method."""
    return [k for k, row in rows.items() if "others" in methods[row[0][0].method].needs]


def among(row: Row, bodies: Sequence[tuple[Track, int]]) -> Row:
    """Return the steps of a member, the first of which knows other bodies and how many frames later they begin.

    Only the first step does: how long it takes is not known before.
    """
    (step, view), *later = row
    return [(step, replace(view, others=[late(body, frames) for body, frames in bodies])), *later]


def late(body: Track, frames: int) -> Track:
    """Return a body that does the same so many frames later, or earlier, and is in its first pose before."""
    rows = np.clip(np.arange(max(len(body) + frames, 1)) - frames, 0, len(body) - 1)
    return replace(body, centres=body.centres[rows])
