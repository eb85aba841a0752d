"""Which member of a cast gets which place to sit or lie on. Network frame, metres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from ...motion import Goal

APART = {"sit": 0.55, "lie": 0.75}
"""Metres between the pelvises of two bodies beside each other on one piece: the width of a body with its elbows."""

BETWEEN_PIECES = 0.45
"""The same for seats of different pieces: chairs are as far apart as they were put."""

WORTH = 2.0
"""Metres of way that the best place on a piece is worth over one of score 0."""

MOST = 16
"""Places on one piece that are considered, the best ones."""

IMPOSSIBLE = 1e6


@dataclass(frozen=True)
class Place:
    """A place on a piece of furniture. piece: its number. goal: of the pelvis. score: from 0 to 1. surface: metres from
    the floor to what carries the body."""

    piece: int
    goal: Goal
    score: float
    surface: float = 0.0


def assign(
    starts: Sequence[np.ndarray | None],
    pools: Sequence[Sequence[int]],
    places: Sequence[Place],
    occupied: np.ndarray | None = None,
) -> list[Place | None]:
    """Return the place of each member, or None for those for whom none is left.

    starts: where each member comes from (3,), or None. pools: the pieces of which each member takes one. places: on
    all pieces. occupied: (N, 3) pelvises of bodies that sit or lie already. As many members as possible get a place;
    of the ways to do so, the one with the best places and the shortest ways is chosen.
    """
    free = [place for place in places if occupied is None or not _taken(place, occupied)]
    chosen = _apart(free, pools)
    if not chosen:
        return [None] * len(pools)
    cost = np.full((len(pools), len(chosen)), IMPOSSIBLE)
    for m, pool in enumerate(pools):
        for k, place in enumerate(chosen):
            if place.piece in pool:
                cost[m, k] = WORTH * (1 - place.score) + _away(starts[m], place)
    found: list[Place | None] = [None] * len(pools)
    for m, k in zip(*linear_sum_assignment(cost), strict=True):
        if cost[m, k] < IMPOSSIBLE:
            found[m] = chosen[k]
    return found


def spread(points: np.ndarray, scores: np.ndarray, count: int, apart: float) -> list[int]:
    """Return up to ``count`` of the points (N, 3) that are at least ``apart`` metres from each other, horizontally.

    As many as there can be; among these, those with the highest sum of scores (N,).
    """
    gaps = np.linalg.norm((points[:, None] - points[None])[..., [0, 2]], axis=-1)
    fits = gaps >= apart - 1e-6
    best: list[int] = []
    value = (0, 0.0)
    limit = np.concatenate([np.cumsum(scores[::-1])[::-1], [0.0]])

    def extend(chosen: list[int], begin: int, total: float) -> None:
        nonlocal best, value
        if (len(chosen), total) > value:
            best, value = list(chosen), (len(chosen), total)
        if len(chosen) == count:
            return
        for k in range(begin, len(points)):
            possible = len(chosen) + len(points) - k, total + limit[k]
            if possible[0] < value[0] or (value[0] == count and possible[1] <= value[1]):
                return
            if fits[k, chosen].all():
                extend([*chosen, k], k + 1, total + float(scores[k]))

    extend([], 0, 0.0)
    return best


def _apart(places: Sequence[Place], pools: Sequence[Sequence[int]]) -> list[Place]:
    """Return places on all pieces that can be taken at the same time, the best pieces' first."""
    kept: list[Place] = []
    for piece in dict.fromkeys(place.piece for place in places):
        wanted = sum(piece in pool for pool in pools)
        own = [place for place in places if place.piece == piece and not _crowded(place, kept)]
        own = sorted(own, key=lambda place: -place.score)[:MOST]
        if not own or not wanted:
            continue
        points = np.array([place.goal.position for place in own])
        scores = np.array([place.score for place in own])
        kept += [own[k] for k in spread(points, scores, wanted, APART[own[0].goal.action])]
    return kept


def _crowded(place: Place, kept: Sequence[Place]) -> bool:
    return any(_gap(place.goal.position, other.goal.position) < BETWEEN_PIECES for other in kept)


def _taken(place: Place, occupied: np.ndarray) -> bool:
    """Whether a body sits or lies where this place is, or so near that there is no room for another one."""
    if not len(occupied):
        return False
    level = np.abs(occupied[:, 1] - place.goal.position[1]) < 0.5
    gaps = np.linalg.norm((occupied - place.goal.position)[:, [0, 2]], axis=-1)
    return bool((level & (gaps < BETWEEN_PIECES)).any())


def _away(start: np.ndarray | None, place: Place) -> float:
    return 0.0 if start is None else _gap(start, place.goal.position)


def _gap(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.linalg.norm((np.asarray(a) - np.asarray(b))[[0, 2]]))
