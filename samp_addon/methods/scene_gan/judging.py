"""How far a drawn window can be followed: the body is on free ground, out of furniture and clear of other bodies.

Network frame, metres.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...body import balls, human
from ...body.balls import Balls, Track
from ...motion import Motion
from .ground import Ground

EVERY = 4
"""Step, in frames, between those in which the body is compared with furniture and with other bodies."""
FEET = (7, 8, 10, 11)
"""Ankles and feet, whose skin is close to the floor."""
DEEPEST, DEEPEST_LOW = 0.03, 0.08
"""Metres by which the balls of a body may be in furniture: of an upright body, and of a low one, which may sit."""
CLEARANCE = 0.06
"""Least distance between the balls of two bodies, metres. Balls lie up to 2 cm under the skin."""
STANDING_ROOM = 0.35
"""Least horizontal distance from the axis of a standing body to other bodies, metres."""
FAR = 2.5
"""Metres between the middles of two bodies from which on they cannot touch."""


@dataclass(frozen=True)
class Verdict:
    """frames: how many of a window's 64 can be followed. depth: metres in furniture in these, on average."""

    frames: int
    depth: float


@dataclass(frozen=True)
class Judge:
    """ground: where a body can be. others: bodies over time from the take's first frame on; after its last frame each
    keeps its pose. fps: frame rate of the windows."""

    ground: Ground
    others: Sequence[Track] = ()
    fps: float = 30.0

    def of(self, root: np.ndarray, rotations: np.ndarray, floor: float, first: int) -> Verdict:
        """Return the verdict on a window, root (65, 3) and rotations (65, 22, 4), whose first frame is given.

        floor: height of the ground in the given frame. first: number of the given frame in the take. A fault that the
        given frame has already is tolerated until it has ended once.
        """
        rows = np.arange(0, len(root), EVERY)
        centres = self._balls.at(Motion(root[rows], rotations[rows]))
        depth = self.ground.depth(centres[:, self._off_floor], self._balls.radii[self._off_floor])
        most = np.where(self.ground.upright(root[rows]), DEEPEST, DEEPEST_LOW)
        beside = ~self.ground.fits(root, floor)
        blocked = _newly(depth > most) | _newly(self._near_others(centres, first + rows))
        wrong = _newly(beside) | np.repeat(blocked, EVERY)[: len(root)]
        frames = int(wrong.argmax()) - 1 if wrong.any() else len(root) - 1
        return Verdict(frames, float(depth[rows <= frames].mean()))

    def meets(self, places: np.ndarray) -> np.ndarray:
        """Return at which places on the floor (N, 3) a standing body would meet another one in the first frame (N,)."""
        found = np.zeros(len(places), bool)
        for other in self.others:
            gaps = np.linalg.norm((places[:, None] - other.centres[0])[..., [0, 2]], axis=-1) - other.radii
            level = np.abs(places[:, 1] - other.centres[0, :, 1].min()) < self.ground.standing
            found |= level & (gaps.min(1) < STANDING_ROOM)
        return found

    def _near_others(self, centres: np.ndarray, frames: np.ndarray) -> np.ndarray:
        """Return in which frames (T,) of the take a body with balls at (T, S, 3) is too close to another one."""
        near = np.zeros(len(frames), bool)
        for other in self.others:
            at = np.minimum(np.round(frames / self.fps * other.rate).astype(int), len(other) - 1)
            away = np.linalg.norm(centres.mean(1) - other.centres[at].mean(1), axis=-1)
            for row in np.flatnonzero(away < FAR):
                gap = np.linalg.norm(centres[row][:, None] - other.centres[at[row]], axis=-1)
                near[row] |= (gap - self._balls.radii[:, None] - other.radii).min() < CLEARANCE
        return near

    @cached_property
    def _balls(self) -> Balls:
        return balls.of_body(human.load())

    @cached_property
    def _off_floor(self) -> np.ndarray:
        """The numbers of the balls that are not of the feet."""
        body = self._balls.centres
        joint = body.weight_joints[np.arange(len(body.weights)), body.weights.argmax(1)]
        return np.flatnonzero(~np.isin(joint, FEET))


def _newly(wrong: np.ndarray) -> np.ndarray:
    """Return flags (T,) without the run of flags that begins in the first frame."""
    return wrong & np.maximum.accumulate(~wrong)
