"""Routes over stairs, unfolded: MotionNet has only seen flat floors, where a step is longer than a tread.

A flight is stretched until each tread has the length of a step. What lies before it moves back; the goal stays where it
is. `Unfolded.folded` is the way back. Network frame, metres.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...frames import ground_lengths
from ...scene.flights import Flight

STEP = 0.6
"""Metres of a step of MotionNet's walk."""

FAR = 100.0

BESIDE = 0.9
"""Metres before and after a flight in which a foot belongs to it."""


@dataclass(frozen=True)
class Unfolded:
    """A path with its flights stretched.

    points: (M, 3) of the path. flights: on the real path, in order. begins: (K,) metres along the stretched path of
    each first riser. risers: for each flight, (R,) stretched distances of the risers from the first one. moved:
    (K + 1, 3) by which the path before each flight, and after the last one, is moved; the last row is zero.
    """

    points: np.ndarray
    flights: Sequence[Flight]
    begins: np.ndarray
    risers: Sequence[np.ndarray]
    moved: np.ndarray

    @classmethod
    def of(cls, path: np.ndarray, flights: Sequence[Flight]) -> Unfolded:
        """Unfold a path (M, 3) on the ground."""
        risers = [_stretched(flight.risers) for flight in flights]
        longer = [float(new[-1]) - flight.length for new, flight in zip(risers, flights, strict=True)]
        steps = [-extra * flight.direction for extra, flight in zip(longer, flights, strict=True)]
        moved = np.concatenate([np.cumsum(np.reshape(steps, (-1, 3))[::-1], 0)[::-1], np.zeros((1, 3))])
        lengths = ground_lengths(path)
        points = []
        for k in range(len(flights) + 1):
            after = -np.inf if k == 0 else flights[k - 1].end
            before = np.inf if k == len(flights) else flights[k].begin
            points.append(path[(lengths > after) & (lengths < before)] + moved[k])
            if k < len(flights):
                ends = flights[k].origin + np.outer([0.0, flights[k].length], flights[k].direction)
                ends[:, 1] = flights[k].treads[[0, -1]]
                points.append(ends + moved[[k, k + 1]])
        begins = np.array([flight.begin for flight in flights]) + np.append(0.0, np.cumsum(longer)[:-1])
        return cls(np.concatenate(points), tuple(flights), begins, risers, moved)

    def flight_at(self, travelled: np.ndarray) -> np.ndarray:
        """Return the number (...) of the flight at distances along the stretched path, -1 beside all of them."""
        away = np.stack(
            [
                np.maximum(begin - travelled, travelled - begin - risers[-1])
                for begin, risers in zip(self.begins, self.risers, strict=True)
            ]
        )
        nearest = away.argmin(0)
        return np.where(np.take_along_axis(away, nearest[None], 0)[0] <= BESIDE, nearest, -1)

    def folded(self, point: np.ndarray, travelled: float) -> np.ndarray:
        """Return where a point (3,) of the stretched path is on the real one; its height is kept."""
        k = int(self.flight_at(np.array(travelled)))
        if k < 0:
            return point - self.moved[int((travelled > self.begins).sum())]
        flight, risers = self.flights[k], self.risers[k]
        before = point - self.moved[k]
        along = float(flight.along(before))
        # Beside the risers nothing is stretched.
        known = np.concatenate([[-FAR], risers, [risers[-1] + FAR]])
        real = np.concatenate([[-FAR], flight.risers, [flight.length + FAR]])
        return before + (float(np.interp(along, known, real)) - along) * flight.direction


def _stretched(risers: np.ndarray) -> np.ndarray:
    """Return distances of risers with a whole number of steps on each tread."""
    treads = np.diff(risers)
    steps = np.maximum(np.round(treads / STEP), 1.0)
    return np.append(0.0, np.cumsum(np.maximum(treads, steps * STEP)))
