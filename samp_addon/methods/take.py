"""Takes and failures: what a method makes. Network frame, metres."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..frames import direction_yaw
from ..motion import Goal, Motion
from ..refine.feet.grounding import lowest_sole
from ..refine.refinement import Refined
from ..vocabulary import SEATED


@dataclass(frozen=True)
class SubGoal:
    """A place that a take passes: position (3,) of the pelvis, direction (3,) of its facing, and its frame."""

    position: np.ndarray
    direction: np.ndarray
    frame: int


@dataclass(frozen=True)
class Take:
    """One generated Motion, and what else its method knows; what it does not know is None.

    method: the name of the method. seconds: by stage. attempts: how often the driver tried. goal: where the pelvis
    ends, for walks at standing height. waypoints: (N, 3) of the path on the floor, its start first. sub_goals: places
    passed on the way. camera: name of the camera whose picture the take fits. steps: the takes that it was joined
    from; empty for a single action. laid_ground: height of the floor that was assumed in a scene without one, or None.
    refined: what its refinement changed. remarks: sentences for the artist, such as that a destination was moved.
    """

    seed: int
    motion: Motion
    method: str = "samp"
    seconds: dict[str, float] = field(default_factory=dict)
    attempts: int = 1
    goal: Goal | None = None
    waypoints: np.ndarray | None = None
    sub_goals: tuple[SubGoal, ...] | None = None
    camera: str | None = None
    steps: tuple[Take, ...] = ()
    laid_ground: float | None = None
    refined: Refined | None = None
    remarks: tuple[str, ...] = ()

    @property
    def floor(self) -> float:
        """Height of the lowest ground that the take is on: its path's, else the assumed floor, else its feet's."""
        if self.waypoints is not None:
            return float(self.waypoints[:, 1].min())
        return self.laid_ground if self.laid_ground is not None else float(self._lowest().min())

    @property
    def floor_start(self) -> np.ndarray:
        """The ground (3,) on which the take begins."""
        return self.waypoints[0] if self.waypoints is not None else self._below_pelvis(0)

    @property
    def floor_end(self) -> np.ndarray:
        """The ground (3,) from which a path can lead on: in front of the seat, or where the character stands."""
        if self.waypoints is not None:
            return self.waypoints[-1]
        return self._below_pelvis(-1)

    @property
    def below_end(self) -> np.ndarray:
        """The ground (3,) under the pelvis at the take's end."""
        place = self.motion.root[-1].copy()
        place[1] = self.floor_end[1]
        return place

    @property
    def exit(self) -> tuple[np.ndarray, float]:
        """Where the next step's path begins: ground (3,), and the facing at the end in radians."""
        yaw = float(direction_yaw(self.motion.headings()[-1]))
        seated = self.goal is not None and self.goal.action in SEATED
        return (self.floor_end if seated else self.below_end), yaw

    def _below_pelvis(self, frame: int) -> np.ndarray:
        place = self.motion.root[frame].copy()
        place[1] = self.laid_ground if self.laid_ground is not None else self._lowest()[frame]
        return place

    def _lowest(self) -> np.ndarray:
        """Height of the lowest sole or joint in each frame (T,)."""
        return np.minimum(lowest_sole(self.motion), self.motion.forward_kinematics()[0][..., 1].min(1))


@dataclass(frozen=True)
class Failure:
    """A take that could not be made, and why, in one sentence."""

    seed: int
    message: str
