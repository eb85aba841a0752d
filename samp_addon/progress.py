"""How long work tells how far it is, and shows what it has so far.

A progress function takes the stage's name and the share done, 0 to 1; what it raises stops the work. It may have a
method ``show``, which is given Motions to look at meanwhile: a single frame, or a whole take.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .motion import Motion

Progress = Callable[[str, float], None]


def show(progress: Callable[..., None], motion: Motion) -> None:
    """Gives a motion to whoever looks at this progress, if anybody does."""
    shown = getattr(progress, "show", None)
    if shown is not None:
        shown(motion)


class Part:
    """A part of some work as its whole sees it: shares from begin on, span wide. stage: a name for all its stages."""

    def __init__(
        self, whole: Progress, begin: float = 0.0, span: float = 1.0, stage: str | None = None
    ) -> None:
        self._whole, self._begin, self._span, self._stage = whole, begin, span, stage

    def __call__(self, stage: str, share: float) -> None:
        self._whole(self._stage or stage, self._begin + share * self._span)

    def show(self, motion: Motion) -> None:
        show(self._whole, motion)


class Stage:
    """One stage of some work, which only says its share."""

    def __init__(self, whole: Progress, name: str) -> None:
        self._whole, self._name = whole, name

    def __call__(self, share: float) -> None:
        self._whole(self._name, share)

    def show(self, motion: Motion) -> None:
        show(self._whole, motion)
