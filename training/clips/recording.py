"""A captured motion on the skeleton that it was captured with, whatever file it comes from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...samp_addon import rotation


@dataclass(frozen=True, eq=False)
class Recording:
    """Joints over time in the axes and the length unit of the file; neither matters, see mapping.py.

    names: (J,) of the joints. parents: (J,) indices, -1 for none, parents before children. rest: (J, 3) joint
    positions in the rest pose, and tips: (J, 3) the ends of their bones there (the joint itself where that is not
    known). positions: (T, J, 3). turns: (T, J, 4) quaternions in the file's axes from the rest pose to the pose, so
    the rest pose has identities. labels: (T,) names of what goes on, if the file tells.
    """

    name: str
    fps: float
    names: tuple[str, ...]
    parents: np.ndarray
    rest: np.ndarray
    tips: np.ndarray
    positions: np.ndarray
    turns: np.ndarray
    labels: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.positions)

    @property
    def skeleton(self) -> tuple:
        """What is equal for recordings on the same skeleton: names and rest pose, to a thousandth of its size."""
        size = max(float(np.ptp(self.rest, axis=0).max()), 1e-9)
        return self.names, (np.round((self.rest - self.rest[0]) / size, 3) + 0.0).tobytes()

    def rested_at(self, positions: np.ndarray, turns: np.ndarray) -> Recording:
        """The same motion with a pose, positions (J, 3) and turns (J, 4), in the place of the rest pose."""
        bones = rotation.rotate(turns, self.tips - self.rest)
        return replace(
            self,
            rest=positions,
            tips=positions + bones,
            turns=rotation.multiply(self.turns, rotation.conjugate(turns)),
        )

    def at_rate(self, fps: float) -> Recording:
        """The same motion at another frame rate; the time of the first frame stays."""
        if abs(self.fps - fps) < 0.05 or len(self) < 2:
            return replace(self, fps=fps)
        at = np.arange(0, len(self) - 1 + 1e-6, self.fps / fps)
        low = np.minimum(at.astype(int), len(self) - 2)
        t = at - low
        between = self.positions[low] * (1 - t)[:, None, None] + self.positions[low + 1] * t[:, None, None]
        return replace(
            self,
            fps=fps,
            positions=between,
            turns=rotation.slerp(self.turns[low], self.turns[low + 1], t[:, None]),
            labels=None if self.labels is None else self.labels[np.round(at).astype(int)],
        )


def of_local(
    name: str,
    fps: float,
    names: Sequence[str],
    parents: Sequence[int],
    offsets: np.ndarray,
    local: np.ndarray,
    moved: np.ndarray,
    ends: np.ndarray | None = None,
    labels: np.ndarray | None = None,
) -> Recording:
    """A recording out of local rotations.

    offsets: (J, 3) of the joints from their parents in the rest pose. local: (T, J, 4) rotations from it. moved:
    (T, J, 3) offsets over time; the root's are its positions. ends: (J, 3) from the joints to their bones' ends in
    the rest pose; if left out, to the children's middle.
    """
    parents = np.asarray(parents, int)
    turns, positions = np.empty_like(local, dtype=np.float64), np.empty(moved.shape)
    rest = np.array(offsets, dtype=np.float64)
    for j, parent in enumerate(parents):
        if parent < 0:
            turns[:, j], positions[:, j] = local[:, j], moved[:, j]
        else:
            turns[:, j] = rotation.multiply(turns[:, parent], local[:, j])
            positions[:, j] = positions[:, parent] + rotation.rotate(turns[:, parent], moved[:, j])
            rest[j] = rest[parent] + offsets[j]
    if ends is None:
        below = [np.flatnonzero(parents == j) for j in range(len(parents))]
        ends = np.array([offsets[k].mean(0) if len(k) else np.zeros(3) for k in below])
    return Recording(name, fps, tuple(names), parents, rest, rest + ends, positions, turns, labels)
