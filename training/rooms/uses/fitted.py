"""Fitted uses: sits and lies optimised for each piece by training/fitting."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...composition.sequence import Sequence
from ...composition.stitch import WalkIndex
from ...fitting.lying.lies import FittedLies
from ...fitting.shapes.pieces import FittingPiece
from ...fitting.sits import FittedComposer, trimmed
from ...mocap.events import SitEvent
from ..layout.stock import Item
from .composed import Composed
from .use import Use, cached, of_sequence, place_of, sound, with_rises

SITS, TRIES = 10, 40  # sits kept and tried for a piece
LIES, LIE_TRIES = 6, 16


class Fitted:
    """Uses fitted to each piece; see use.Uses."""

    def __init__(
        self, composed: Composed, walks: WalkIndex, names: list[str], firsts: np.ndarray, cache: Path
    ) -> None:
        """Take the events and reclines of ``composed``.

        names, firsts: names and first frames of the bank's clips. cache: folder with a file for each item.
        """
        self.events = [trimmed(event) for event in composed.events]
        self.reclines, self.walks = composed.reclines, walks
        self.first = dict(zip(names, (int(f) for f in firsts), strict=True))
        self._sound: dict[str, list[Use]] = {}
        self.cache = Path(cache)
        self.cache.mkdir(parents=True, exist_ok=True)

    def of(self, item: Item) -> list[Use]:
        """Return all uses of an item; see use.Uses."""
        if item.name not in self._sound:
            made = cached(self.cache / f"{item.name}.pkl", lambda: self._made(item))
            self._sound[item.name] = with_rises(sound(made, item))
        return self._sound[item.name]

    def _made(self, item: Item) -> list[Use]:
        seed = int.from_bytes(hashlib.sha256(item.name.encode()).digest()[:4], "little")
        rng = np.random.default_rng(seed)
        piece = FittingPiece(0, item.category, item.name, item.triangles)
        uses: list[Use] = []
        if piece.seats:
            composer = FittedComposer([piece], self.walks, seed, approaches=0)
            levels = np.array([goal.position[1] for goal in piece.seats])
            near = [e for e in self.events if np.abs(levels - e.pelvis[1]).min() < 0.15]
            for k in rng.permutation(len(near))[:TRIES]:
                for made in composer.compose(near[k]):
                    use = of_sequence(made, 0, self._source(near[k], made), True)
                    uses.append(replace(use, place=place_of(uses, use)))
                if len(uses) == SITS:
                    break
        if piece.beds:
            lies = FittedLies([piece], self.events, self.reclines, lambda clip, frames: (clip, frames), seed)
            made = [m for m in (lies.compose() for _ in range(LIE_TRIES)) if m is not None][:LIES]
            uses += [of_sequence(m, 100 + k, None, True) for k, m in enumerate(made)]
        return uses

    def _source(self, event: SitEvent, made: Sequence) -> np.ndarray | None:
        """Return the bank frames (T,) of a sit at its captured pace, None at another."""
        last = event.leave_end if event.up_end > event.seat_end else event.seat_end
        first = self.first.get(event.clip.name)
        if first is None or len(made) > last + 1 - event.entry:
            return None
        return first + event.entry + np.arange(len(made))
