"""A hand of a take on a target in some of its frames. Network frame, metres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..easing import smoothstep
from ..motion import Motion
from ..refine.hands.palm import HandContact
from ..refine.hands.reaching import reach
from .retiming import phase_starts

EASE = 0.5
"""Seconds in which the hand moves to its target, and back."""

MISSED = 0.01
"""Metres off its target beyond which a palm does not reach it."""


@dataclass(frozen=True)
class HandOnTarget:
    """A motion with a hand on its target. missed: metres by which the palm is off it at most, while it is to be there.
    frame: in which that is."""

    motion: Motion
    contact: HandContact
    missed: float
    frame: int


def hand_target(
    motion: Motion,
    side: str,
    places: np.ndarray,
    first: int = 0,
    last: int | None = None,
    ease: float = EASE,
    facing: np.ndarray | None = None,
) -> HandOnTarget:
    """Return a motion whose palm is on a target from frame ``first`` to ``last``.

    side: "left" or "right". places: (3,), or (T, 3) for a target that moves. last: the end of the motion if left out.
    The palm moves there in the ``ease`` seconds before and back in those after. facing: (3,) or (T, 3), what the palm
    faces, as far as it can. The arm turns, the trunk where the arm alone does not reach, both within their limits; all
    other joints, and the frames before and after, stay as they are. Raises ValueError for an empty range.
    """
    count = len(motion)
    end = count - 1 if last is None else min(last, count - 1)
    first = max(first, 0)
    if end < first:
        raise ValueError(f"frames {first} to {end} are empty")
    spread = lambda values: None if values is None else np.broadcast_to(values, (count, 3)).astype(float)
    contact = HandContact(side, spread(places), weights(count, first, end, ease * motion.fps), spread(facing))
    made = reach(motion, contact)
    frame = first + int(made.missed[first : end + 1].argmax())
    return HandOnTarget(made.motion, contact, float(made.missed[frame]), frame)


def weights(count: int, first: int, last: int, ease: float) -> np.ndarray:
    """Return the weight (T,) of a target in each frame: 1 from first to last, eased over ``ease`` frames outside."""
    at = np.arange(count)
    away = np.maximum(first - at, at - last)
    return smoothstep(1 - np.maximum(away, 0) / max(ease, 1.0))


def resting_frames(motion: Motion) -> tuple[int, int]:
    """Return the frames in which a hand is on its target where none are given: those of the rest, else all."""
    return phase_starts(motion).get("hold", 0), len(motion) - 1
