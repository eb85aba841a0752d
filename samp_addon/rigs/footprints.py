"""The ground that a take shows: where its feet stand, it is as high as their soles. Network frame, metres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from .. import rotation
from ..motion import Motion
from ..refine.feet.foot import FEET, Foot, sole_points
from ..refine.feet.stances import SHORTEST, SLOW, UPRIGHT
from ..refine.runs import runs

SAME_PLACE = 0.3  # metres around a footprint in which a higher one is a foot in the air


@dataclass(frozen=True)
class Footprints:
    """Footprints at places (N, 3), made at times (N,), frames; the ground is level around each of them.

    It answers as refine/field.py's Field does, for soles where there is no scene to ask.
    """

    places: np.ndarray
    times: np.ndarray

    @classmethod
    def of(cls, motion: Motion) -> Footprints:
        """Those of a take. Where no foot stands, the lowest sole of the whole take is one."""
        found, lowest = [], []
        for foot in FEET:
            low, spans = _spells(motion, foot)
            lowest.append(low[np.argmin(low[:, 1])])
            for first, last in spans:
                spot = low[first:last].mean(0)
                spot[1] = np.percentile(low[first:last, 1], 10)
                found.append((spot, (first + last - 1) / 2))
        found = [print_ for print_ in found if not _in_the_air(print_[0], found)]
        found.sort(key=lambda print_: print_[1])
        found = found or [(min(lowest, key=lambda spot: spot[1]), 0.0)]
        return cls(np.array([place for place, _ in found]), np.array([time for _, time in found]))

    def support(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Heights (N,) of the ground under soles (N, 3), that of the nearest footprint, and its normals (N, 3)."""
        away = np.linalg.norm((points[:, None] - self.places)[..., [0, 2]], axis=-1)
        return self.places[away.argmin(1), 1], np.tile([0.0, 1.0, 0.0], (len(points), 1))

    def height(self, count: int) -> np.ndarray:
        """Height (count,) of the ground in each frame, from footprint to footprint."""
        return np.interp(np.arange(count), self.times, self.places[:, 1])


def _spells(motion: Motion, foot: Foot) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """The lowest point (T, 3) of a sole, and the runs in which it is slow and level."""
    positions, globals_ = motion.forward_kinematics()
    ends = sole_points(positions, globals_, motion.rest_joints, foot.side)
    low = np.where((ends[0][:, 1] < ends[1][:, 1])[:, None], *ends)
    if len(motion) < 2:
        return low, [(0, len(motion))]
    speeds = [np.linalg.norm(np.gradient(end, 1 / motion.fps, axis=0), axis=-1) for end in ends]
    speed = uniform_filter1d(np.min(speeds, axis=0), 3, mode="nearest")
    up = rotation.rotate(globals_[:, foot.ankle], np.broadcast_to([0.0, 1.0, 0.0], low.shape))[:, 1]
    least = max(2, round(SHORTEST * motion.fps / 30))
    return low, runs((speed < SLOW) & (up > UPRIGHT), least, 2)


def _in_the_air(place: np.ndarray, others: Sequence[tuple[np.ndarray, float]]) -> bool:
    """Whether a foot stood lower at the same place: then it was only slow, not standing."""
    return any(
        np.linalg.norm((place - other)[[0, 2]]) < SAME_PLACE and 0.02 < place[1] - other[1] < 0.5
        for other, _ in others
    )
