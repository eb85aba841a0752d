"""A training sequence: a motion with its goals, its piece of furniture, and flags of unusable frames."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...samp_addon.vocabulary import POSTURE_NAMES

ACTION_OF_LABEL = {
    "idle": 0, "shift": 0, "other": 0, "stand_up": 0, "get_up": 0, "walk": 1, "run": 2,
    "sit_down": 3, "sit": 3, "lie_down": 4, "lie": 4,
}  # fmt: skip
SMOOTHING = 15  # frames of the window that turns labels into continuous action weights


@dataclass
class Sequence:
    """A motion with its goals; root (T, 3), rotations (T, 22, 4), labels (T,), feet (T, 2), bad (T,) as in mocap.Clip.

    goal: (T, 6) world position and direction of the current goal; goal_action: (T,) index into ACTIONS.
    piece: index of the furniture, -1 for none; placement: (x, z, yaw) of the piece in the world, metres and radians.
    open_start, open_end: True where the motion was cut while moving, so that its continuation is unknown.
    kind: share of the data to which it belongs, for balanced sampling. weight: of its frames in sampling, relative
    to others of the kind. more: (piece, placement) of other furniture that the motion fits.
    posture: (9,) share of the rest in each of vocabulary.POSTURE_NAMES; zeros where it is unknown.
    """

    kind: str
    root: np.ndarray
    rotations: np.ndarray
    labels: np.ndarray
    feet: np.ndarray
    bad: np.ndarray
    goal: np.ndarray
    goal_action: np.ndarray
    piece: int = -1
    placement: tuple[float, float, float] = (0.0, 0.0, 0.0)
    open_start: bool = True
    open_end: bool = True
    hands: np.ndarray | None = field(default=None)
    weight: float = 1.0
    more: list[tuple[int, tuple[float, float, float]]] = field(default_factory=list)
    posture: np.ndarray = field(default_factory=lambda: np.zeros(len(POSTURE_NAMES)))

    def __len__(self) -> int:
        return len(self.root)

    def action_weights(self) -> np.ndarray:
        """Return continuous action weights (T, 5)."""
        one_hot = np.eye(5)[[ACTION_OF_LABEL[label] for label in self.labels]]
        half = SMOOTHING // 2
        kernel = np.hanning(SMOOTHING + 2)[1:-1]
        kernel /= kernel.sum()
        padded = np.pad(one_hot, ((half, half), (0, 0)), mode="edge")
        return np.stack([np.convolve(padded[:, k], kernel, "valid") for k in range(5)], -1)

    def contacts(self) -> np.ndarray:
        """Return contacts (T, 5): pelvis, right hand, left hand, right foot, left foot."""
        pelvis = np.isin(self.labels, ("sit", "lie")).astype(float)
        hands = np.zeros((len(self), 2)) if self.hands is None else self.hands
        return np.column_stack([pelvis, hands, self.feet])


_ARRAYS = ("root", "rotations", "goal", "goal_action", "bad")


def _more(sequences: list[Sequence]) -> tuple[np.ndarray, np.ndarray]:
    """Return other pieces (S, K), padded with -1, and their placements (S, K, 3)."""
    most = max((len(s.more) for s in sequences), default=0)
    pieces, placements = np.full((len(sequences), most), -1), np.zeros((len(sequences), most, 3), np.float32)
    for k, sequence in enumerate(sequences):
        for i, (piece, place) in enumerate(sequence.more):
            pieces[k, i], placements[k, i] = piece, place
    return pieces, placements


def save(
    path: Path,
    sequences: list[Sequence],
    pieces: dict[str, np.ndarray],
    mirrored: bool = False,
    goal_grid: bool = False,
) -> None:
    """Save all sequences and the pieces' grids in one compressed file, quaternions as int16.

    mirrored: whether the mirror image of every sequence is added when the file is read. goal_grid: whether the grids
    are centred on the goals.
    """
    lengths = np.array([len(s) for s in sequences])
    more_pieces, more_placements = _more(sequences)
    cat = lambda f, dtype: np.concatenate([f(s) for s in sequences]).astype(dtype)
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(
        path,
        lengths=lengths,
        kinds=np.array([s.kind for s in sequences]),
        pieces=np.array([s.piece for s in sequences]),
        placements=np.array([s.placement for s in sequences], dtype=np.float32),
        weights=np.array([s.weight for s in sequences], dtype=np.float32),
        more_pieces=more_pieces,
        more_placements=more_placements,
        mirrored=np.array(mirrored),
        goal_grid=np.array(goal_grid),
        postures=np.array([s.posture for s in sequences], dtype=np.float32).reshape(-1, len(POSTURE_NAMES)),
        open_ends=np.array([(s.open_start, s.open_end) for s in sequences]),
        root=cat(lambda s: s.root, np.float32),
        rotations=np.round(cat(lambda s: s.rotations, np.float64) * 32767).astype(np.int16),
        actions=cat(Sequence.action_weights, np.float16),
        contacts=cat(Sequence.contacts, np.float16),
        goal=cat(lambda s: s.goal, np.float32),
        goal_action=cat(lambda s: s.goal_action, np.int8),
        bad=cat(lambda s: s.bad, bool),
        **{f"piece_{k}": v for k, v in pieces.items()},
    )
