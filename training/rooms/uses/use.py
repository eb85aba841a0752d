"""Uses of a piece of furniture: sits and lies in its own frame.

``Uses`` is the interface of their sources: captured sits adapted to a seat (composed.py), sits fitted to each piece
(fitted.py), or those of a file (fitted_set.py).
"""

from __future__ import annotations

import pickle
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import numpy as np

from ....samp_addon import rotation
from ....samp_addon.body import human
from ....samp_addon.evaluation.obstacles import Obstacles
from ....samp_addon.motion import Motion
from ...composition.sequence import Sequence
from ...mocap.clip_files import Clip
from ...mocap.events import turned
from ..episodes import depth
from ..episodes.bank import LABELS
from ..layout.stock import Item

BEFORE, AFTER = 50, 20  # frames kept before sitting down and after standing up
SAME_PLACE = 0.12  # metres within which resting pelvises share a place
SOUND = 0.0165  # largest penetration (m) of a piece by the default human; bodies of other builds are deeper
ON_FURNITURE = [LABELS.index(n) for n in ("sit_down", "sit", "stand_up", "lie_down", "lie", "get_up")]
REST = 150  # largest number of frames of the hold at the beginning of a reversed rise


@dataclass(frozen=True)
class Use:
    """A motion on a piece of furniture, in the piece's frame, metres.

    action: "sit" or "lie". place: number of the place on the piece; uses of the same place may follow each other.
    root (T, 3), rotations (T, 22, 4), labels (T,) indices into bank.LABELS, feet (T, 2), hands (T, 2), source (T,)
    bank frames or -1. down, seated, seat_end, up_end: first frame of sitting down, first and last seated, last of
    standing up; down is -1 where the use begins seated, up_end is -1 where it ends seated. fitted: whether it was
    optimised for the piece.
    """

    action: str
    place: int
    root: np.ndarray
    rotations: np.ndarray
    labels: np.ndarray
    feet: np.ndarray
    hands: np.ndarray
    source: np.ndarray
    down: int
    seated: int
    seat_end: int
    up_end: int
    fitted: bool = False


class Uses(Protocol):
    """A source of uses."""

    def of(self, item: Item) -> list[Use]:
        """Return all uses of an item, the same at every call."""


def cached(path: Path, make: Callable[[], list[Use]]) -> list[Use]:
    """Return the uses in a file of the cache; call ``make`` and write the file where it is missing.

    Workers may write the same file at once: each writes its own temporary file, and the last one replaces it.
    """
    if path.exists():
        return pickle.loads(path.read_bytes())
    uses = make()
    part = path.with_suffix(f".{np.random.default_rng().integers(1 << 30)}")
    part.write_bytes(pickle.dumps(uses))
    part.replace(path)
    return uses


def reversed_rise(use: Use) -> Use | None:
    """Return the descent of a use reversed in time, as a rise that begins at rest; None without a descent.

    It begins with up to REST frames of the hold and ends standing, at most AFTER frames after the feet carry the body.
    """
    if use.down < 0:
        return None
    first = max(use.down - AFTER, 0)
    stop = min(use.seated + REST, use.seat_end + 1)
    part = slice(first, stop)
    back = lambda values: values[part][::-1].copy()
    labels = back(use.labels)
    renamed = {
        LABELS.index(a): LABELS.index(b) for a, b in (("sit_down", "stand_up"), ("lie_down", "get_up"))
    }
    labels = np.array([renamed.get(int(label), int(label)) for label in labels], np.uint8)
    count = stop - first
    return replace(
        use, root=back(use.root), rotations=back(use.rotations), labels=labels, feet=back(use.feet),
        hands=back(use.hands), source=back(use.source), down=-1, seated=0, seat_end=count - 1 - (use.seated - first),
        up_end=count - 1 - (use.down - first),
    )  # fmt: skip


def sound(uses: list[Use], item: Item) -> list[Use]:
    """Return the uses in which the default human does not penetrate the item too deeply; soft items keep all."""
    if item.category in depth.SOFT:
        return uses
    body, obstacles = human.load(), Obstacles(item.triangles)
    kept = []
    for use in uses:
        on = np.flatnonzero(np.isin(use.labels, ON_FURNITURE))
        motion = Motion(use.root[on], use.rotations[on])
        if depth.deepest_in_use(obstacles, motion, body) <= SOUND:
            kept.append(use)
    return kept


def place_of(uses: list[Use], made: Use) -> int:
    """Return the number of a use's place on its piece: that of an earlier use within SAME_PLACE, or a new one."""
    pelvis = lambda use: np.median(use.root[use.seated : use.seat_end + 1], axis=0)
    for use in uses:
        if use.action == made.action and np.linalg.norm(pelvis(use) - pelvis(made)) < SAME_PLACE:
            return use.place
    return max((use.place for use in uses), default=-1) + 1


def with_rises(uses: list[Use]) -> list[Use]:
    """Return the uses, and a reversed rise for each that ends at rest."""
    return [*uses, *(rise for use in uses if use.up_end < 0 and (rise := reversed_rise(use)) is not None)]


def of_sequence(made: Sequence, place: int, source: np.ndarray | None = None, fitted: bool = False) -> Use:
    """Return the use in a training sequence that sits or lies; source: its bank frames (T,), None if unknown."""
    labels, count = made.labels, len(made)
    lies = bool((labels == "lie").any())
    going, resting, leaving = (
        ("lie_down", "lie", ("get_up", "stand_up")) if lies else ("sit_down", "sit", ("stand_up",))
    )
    down, still = int(np.argmax(labels == going)), np.flatnonzero(labels == resting)
    ups = np.flatnonzero(np.isin(labels, leaving) & (np.arange(count) > still[-1]))
    start, stop = max(0, down - BEFORE), min(int(ups[-1]) + AFTER, count) if len(ups) else int(still[-1]) + 1
    clip = Clip("", made.root, made.rotations, labels, made.feet, made.bad).cut(start, stop)
    frames = (
        down - start,
        int(still[0]) - start,
        int(still[-1]) - start,
        int(ups[-1]) - start if len(ups) else -1,
    )
    use = in_frame(clip, made.placement, "lie" if lies else "sit", place, frames, None)
    part = slice(start, stop)
    return replace(
        use,
        source=use.source if source is None else source[part].astype(np.int32),
        hands=use.hands if made.hands is None else made.hands[part].astype(np.float32),
        fitted=fitted,
    )


def in_frame(
    clip: Clip, where: tuple[float, float, float], action: str, place: int, frames: tuple[int, int, int, int],
    first: int | None,
) -> Use:  # fmt: skip
    """Return the clip as a use, in the frame of a piece placed at ``where`` (x, z, yaw), metres and radians."""
    root, rotations = turned(
        clip.root - np.array([where[0], 0.0, where[1]]), clip.rotations, -where[2], np.zeros(3)
    )
    index = {label: k for k, label in enumerate(LABELS)}
    count = len(clip)
    source = np.full(count, -1) if first is None else first + np.arange(count)
    return Use(
        action, place, root, rotation.continuous(rotations), np.array([index[x] for x in clip.labels], np.uint8),
        clip.feet.astype(np.float32), np.zeros((count, 2), np.float32), source.astype(np.int32), *frames,
    )  # fmt: skip
