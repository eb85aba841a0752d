"""Lie sequences fitted to their beds: those of training/composition/lies.py, on mattress and pillow."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ....samp_addon import rotation
from ....samp_addon.scene.seats.postures import BED_TO_PELVIS
from ...composition.checks import fault
from ...composition.lies import LieComposer
from ...composition.recline import LEGS, Recline
from ...composition.sequence import Sequence
from ...composition.sits import Furnishing
from ...mocap.clip_files import Clip
from ...mocap.events import SitEvent, turned
from ..provenance import Owed, owed
from ..shapes.pieces import FittingPiece
from ..sit_fit import DEEPEST, group
from .lie_fit import Mattress, settled
from .postures import POSTURES, to_headboard, variants

BUSY = ("lie_down", "lie", "get_up", "sit", "sit_down", "stand_up")
STRIDE = 3
BENT = {"111_12": (64, 96), "113_08": (32,)}
"""Frames of the captured reclines from which the legs' pose may be held: both knees up, or one."""
OFTEN = 0.004  # largest share of checked frames that may be deeper


def with_bent_legs(reclines: list[Recline]) -> list[Recline]:
    """Return the reclines, and variants whose legs stay bent once the back lies."""
    found = list(reclines)
    for recline in reclines:
        name = recline.clip.name.removesuffix("_mirror")
        for frame in BENT.get(name, ()):
            rotations = recline.clip.rotations.copy()
            rotations[frame:, LEGS] = rotations[frame, LEGS]
            found.append(Recline(replace(recline.clip, rotations=rotations), max(recline.still, frame)))
    return found


class FittedLies:
    """Compose fitted lies; report counts kept and dropped ones by reason."""

    def __init__(
        self,
        pieces: list[FittingPiece],
        events: list[SitEvent],
        reclines: list[Recline],
        approach: Callable[[Clip, dict[str, int]], tuple[Clip, dict[str, int]]],
        seed: int,
    ) -> None:
        self.pieces = {piece.index: piece for piece in pieces}
        places = [Furnishing(p.index, p.surface[::8], p.beds) for p in pieces if p.beds]
        kinds = {"back": with_bent_legs(reclines), **variants(reclines)}
        self.composers = {
            posture: LieComposer(places, events, some, approach, seed + k, surface_check=posture != "side")
            for k, (posture, some) in enumerate(kinds.items()) if some
        }  # fmt: skip
        self.rng = np.random.default_rng(seed)
        self.report: Counter[str] = Counter()
        self.owed: list[Owed] = []

    def compose(self) -> Sequence | None:
        """Return a sequence, or None."""
        shares = np.array([POSTURES[posture] for posture in self.composers])
        posture = str(self.rng.choice(list(self.composers), p=shares / shares.sum()))
        made = self.composers[posture].compose()
        if made is None:
            return None
        piece = self.pieces[made.piece]
        before = _in_piece(made)
        lying = np.isin(made.labels, ("lie_down", "lie", "get_up"))
        goal = made.goal[np.flatnonzero(made.goal_action == 4)[0]]
        level = float(goal[1]) - BED_TO_PELVIS
        if posture == "half":
            to_feet = _local(goal[3:], 0.0, 0.0, made.placement[2])
            back = to_headboard(before, made.labels == "lie", piece.surface, level, to_feet)
            if back is None:
                self.report["half sitting: no headboard"] += 1
                return None
            before = replace(before, root=before.root - back * to_feet)
        top = Mattress.of(piece.surface, level)
        after = settled(before, lying, top, piece.give, flat=posture != "half")
        why = fault(after) or self._unfit(after, piece)
        if why is not None:
            self.report[f"fitted, {posture}: {why}"] += 1
            return None
        self.report[f"kept, {posture}"] += 1
        self.owed.append(owed(before, after))
        return self._sequence(made, after)

    def _unfit(self, clip: Clip, piece: FittingPiece) -> str | None:
        """Return where and when a clip, in the piece's frame, penetrates the piece, or None."""
        low, high = piece.triangles.min((0, 1)), piece.triangles.max((0, 1))
        near = ((clip.root > low - 0.8) & (clip.root < high + 0.8))[:, [0, 2]].all(1)
        rows = np.flatnonzero(near)[::STRIDE]
        deep, where = piece.field.deepest(clip.root[rows], clip.rotations[rows])
        over = deep > DEEPEST + piece.give
        if over.mean() <= OFTEN:
            return None
        worst = int(deep.argmax())
        return f"{group(str(where[worst]))} in it, {clip.labels[rows[worst]]}"

    def _sequence(self, made: Sequence, clip: Clip) -> Sequence:
        """Return the sequence in the piece's frame, with its goal at the fitted lying pelvis."""
        x, z, yaw = made.placement
        goal = made.goal.copy()
        goal[:, :3], goal[:, 3:] = _local(goal[:, :3], x, z, yaw), _local(goal[:, 3:], 0.0, 0.0, yaw)
        lies = made.goal_action == 4
        still = made.labels == "lie"
        if still.any():
            goal[lies, :3] = np.median(clip.root[still], axis=0)
        return replace(
            made,
            root=clip.root,
            rotations=clip.rotations,
            goal=goal,
            placement=(0.0, 0.0, 0.0),
            feet=clip.feet,
        )


def _local(points: np.ndarray, x: float, z: float, yaw: float) -> np.ndarray:
    turn = rotation.quaternion_to_matrix(rotation.about_y(-yaw))
    return (points - [x, 0.0, z]) @ turn.T


def _in_piece(made: Sequence) -> Clip:
    """Return the motion of a sequence in its piece's frame."""
    x, z, yaw = made.placement
    root, rotations = turned(made.root - [x, 0.0, z], made.rotations, -yaw, np.zeros(3))
    return Clip("lie", root, rotations, made.labels, made.feet, made.bad)
