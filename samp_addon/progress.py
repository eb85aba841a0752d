"""Progress callbacks of long computations, with previews of intermediate results.

A progress callback takes the stage's name and the share done, 0 to 1; an exception that it raises stops the work. It
may have a method ``show``, which receives Motions to preview: a single frame, or a whole take.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .motion import Motion

Progress = Callable[[str, float], None]


def show(progress: Callable[..., None], motion: Motion) -> None:
    """Preview a motion if the progress callback has a method for it."""
    preview = getattr(progress, "show", None)
    if preview is not None:
        preview(motion)


class SubProgress:
    """Progress of one part of a computation, mapped to the whole: shares from begin to begin + span.

    stage: replaces the names of the part's own stages.
    """

    def __init__(
        self, parent: Progress, begin: float = 0.0, span: float = 1.0, stage: str | None = None
    ) -> None:
        self._parent, self._begin, self._span, self._stage = parent, begin, span, stage

    def __call__(self, stage: str, share: float) -> None:
        self._parent(self._stage or stage, self._begin + share * self._span)

    def show(self, motion: Motion) -> None:
        show(self._parent, motion)


class StageProgress:
    """Progress of one named stage: a callback that takes the share done only."""

    def __init__(self, parent: Progress, name: str) -> None:
        self._parent, self._name = parent, name

    def __call__(self, share: float) -> None:
        self._parent(self._name, share)

    def show(self, motion: Motion) -> None:
        show(self._parent, motion)
