"""The ground under a take, inferred from its feet: as high as the soles of standing feet. Network frame, metres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from ... import rotation
from ...motion import Motion
from ..feet.foot import FEET, Foot, sole_points
from ..feet.stances import SHORTEST, SLOW, UPRIGHT
from ..runs import runs

SAME_PLACE = 0.3  # metres around a footprint within which a higher one is that of a foot in the air


@dataclass(frozen=True)
class Footprints:
    """Footprints of a take; a Ground (refine/field.py) for takes without a scene.

    places: (N, 3). times: (N,) frames. The ground is level around each footprint.
    """

    places: np.ndarray
    times: np.ndarray

    @classmethod
    def of(cls, motion: Motion) -> Footprints:
        """Return the footprints of a take. If no foot ever stands, the lowest place of a sole is the only one."""
        found, lowest = [], []
        for foot in FEET:
            low, spans = _standing_runs(motion, foot)
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
        """Return the heights (N,) of the footprints nearest to soles (N, 3), and the normals (N, 3) of the ground."""
        away = np.linalg.norm((points[:, None] - self.places)[..., [0, 2]], axis=-1)
        return self.places[away.argmin(1), 1], np.tile([0.0, 1.0, 0.0], (len(points), 1))

    def height(self, count: int) -> np.ndarray:
        """Return the height (count,) of the ground in each frame, interpolated between footprints."""
        return np.interp(np.arange(count), self.times, self.places[:, 1])


def _standing_runs(motion: Motion, foot: Foot) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """Return the lowest point (T, 3) of a sole, and the runs of frames in which it is slow and level."""
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
    """Return whether a foot stood lower at the same place: then this one was only slow, not standing."""
    return any(
        np.linalg.norm((place - other)[[0, 2]]) < SAME_PLACE and 0.02 < place[1] - other[1] < 0.5
        for other, _ in others
    )
