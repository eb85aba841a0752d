"""A captured motion on its original skeleton, independent of the file format."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...samp_addon import rotation

SAME = 0.004  # share of the summed bone lengths: offsets that differ by less are equal


@dataclass(frozen=True, eq=False)
class Recording:
    """Joints over time in the axes and the length unit of the file, which mapping.py normalises.

    names: (J,) of the joints. parents: (J,) indices, -1 for none, parents before children. rest: (J, 3) joint
    positions in the rest pose, and tips: (J, 3) the ends of their bones there (the joint itself where that is not
    known). positions: (T, J, 3). turns: (T, J, 4) quaternions in the file's axes from the rest pose to the pose, so
    the rest pose has identities. labels: (T,) names of actions, if the file contains them.
    """

    name: str
    fps: float
    names: tuple[str, ...]
    parents: np.ndarray
    rest: np.ndarray
    tips: np.ndarray
    positions: np.ndarray
    turns: np.ndarray
    rest_turns: np.ndarray
    labels: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.positions)

    def shares_skeleton(self, other: Recording) -> bool:
        """Return whether a rest pose of one recording is also valid for the other.

        Names have to be equal and, in their own frames, bones too. Rest poses may differ, as those of files without
        skin do.
        """
        if self.names != other.names:
            return False
        (own, moves), (others, others_move) = self._offsets(), other._offsets()
        fixed = ~(moves | others_move)
        size = np.linalg.norm(own[fixed], axis=-1).sum()
        return bool(np.abs(own - others)[fixed].max(initial=0.0) < SAME * size)

    def _offsets(self) -> tuple[np.ndarray, np.ndarray]:
        """Return offsets (J, 3) from parents, in the parents' frames, and flags (J,) of joints that move in them."""
        above = np.maximum(self.parents, 0)
        rest = rotation.rotate(rotation.conjugate(self.rest_turns[above]), self.rest - self.rest[above])
        some = slice(None, None, max(len(self) // 20, 1))
        way = self.positions[some] - self.positions[some][:, above]
        seen = rotation.rotate(rotation.conjugate(self.turns[some][:, above]), way)
        away = np.abs(seen - rest).max((0, 2))
        return rest, (self.parents < 0) | (away > SAME * np.linalg.norm(rest, axis=-1).sum())

    def unfolded(self) -> np.ndarray:
        """Return rotations (T, J, 4) of the bones from the rest pose, in the file's axes."""
        return rotation.multiply(self.turns, rotation.conjugate(self.rest_turns))

    def rested_at(self, positions: np.ndarray, turns: np.ndarray) -> Recording:
        """Return the motion with another pose, positions (J, 3) and turns (J, 4), as its rest pose."""
        bones = rotation.rotate(
            rotation.multiply(turns, rotation.conjugate(self.rest_turns)), self.tips - self.rest
        )
        return replace(self, rest=positions, tips=positions + bones, rest_turns=turns)

    def at_rate(self, fps: float) -> Recording:
        """Return the motion resampled to another frame rate; the time of the first frame stays."""
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
    """Return a recording from local rotations.

    offsets: (J, 3) of the joints from their parents in the rest pose. local: (T, J, 4) rotations from it. moved:
    (T, J, 3) offsets over time; the root's are its positions. ends: (J, 3) from the joints to their bones' ends in
    the rest pose; by default to the mean of the children.
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
    still = np.tile([1.0, 0.0, 0.0, 0.0], (len(parents), 1))
    return Recording(name, fps, tuple(names), parents, rest, rest + ends, positions, turns, still, labels)
