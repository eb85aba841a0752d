"""Other furniture for the same sit, so that a network cannot identify the clip by the furniture's shape."""

from __future__ import annotations

import numpy as np

from ...samp_addon.motion import Goal
from ..mocap.clip_files import Clip
from .sequence import Sequence
from .sits import Furnishing, collides, placement, untouched

SEATED_LABELS = ("sit_down", "sit", "stand_up")
MAX_TRIED, MAX_KEPT = 8, 3
HEIGHT_TOLERANCE = 0.02  # metres


def other_pieces(
    sequence: Sequence, seats: list[tuple[Furnishing, Goal]], rng: np.random.Generator
) -> list[tuple[int, tuple[float, float, float]]]:
    """Return (piece, placement) of up to MAX_KEPT other pieces that the motion neither hits nor hovers over."""
    on_seat = sequence.goal_action == 3
    if sequence.kind != "sit" or not on_seat.any():
        return []
    pelvis, direction = np.split(sequence.goal[np.flatnonzero(on_seat)[0]], 2)
    yaw = float(np.arctan2(direction[0], direction[2]))
    fits = [(piece, goal) for piece, goal in seats if abs(goal.position[1] - pelvis[1]) < HEIGHT_TOLERANCE
            and piece.index != sequence.piece]  # fmt: skip
    clip = Clip("", sequence.root, sequence.rotations, sequence.labels, sequence.feet, sequence.bad)
    near = np.isin(sequence.labels, SEATED_LABELS)
    kept: dict[int, tuple[float, float, float]] = {}
    for k in rng.permutation(len(fits))[:MAX_TRIED]:
        piece, goal = fits[k]
        place = placement(goal, pelvis, yaw)
        if collides(clip, piece, place, near) is None and untouched(pelvis, piece, place) is None:
            kept.setdefault(piece.index, place)
        if len(kept) == MAX_KEPT:
            break
    return list(kept.items())
