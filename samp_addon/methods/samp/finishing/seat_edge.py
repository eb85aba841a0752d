"""The front of a seat: where shins and feet have room while a body sits.

People sit down with the seat against their calves, and on stools they pull their feet in below it. A sofa has no room
there: feet that would be inside the seat are moved out of it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .... import skeleton
from ....easing import anticipate
from ....motion import Goal, Motion
from ....refine.inverse_kinematics import solve_limb
from ....scene.seats.postures import SEAT_TO_PELVIS

SHIN = 0.065  # metres from the line of knee and ankle to the calf's skin
MAX_FORWARD = 0.30  # metres by which a foot is moved
CLOSE = 0.6  # horizontal metres from the pelvis to the goal within which a body is sitting down
STEP = 0.04  # metres of height between two samples of the front
WINDOW, SIGMA = 15, 4.0  # frames over which corrections of feet begin early, and are smoothed
_HALF_WIDTH = 0.16


@dataclass(frozen=True)
class SeatFront:
    """The front of an object below and at its seat, metres.

    heights: (H,) above the floor. edge: (H,) how far the object extends in front of the seated pelvis at these
    heights, minus infinity where there is nothing.
    """

    heights: np.ndarray
    edge: np.ndarray

    @classmethod
    def of(cls, points: np.ndarray, goal: Goal, floor: float) -> SeatFront:
        """Measure the front of an object, as a body on ``goal`` meets it.

        points: (N, 3) on its surface, twenty thousand or more. floor: height of the floor.
        """
        away = points - goal.position
        ahead = away @ goal.direction
        aside = np.abs(away @ np.array([goal.direction[2], 0.0, -goal.direction[0]]))
        before = (aside < _HALF_WIDTH) & (ahead > -0.3) & (ahead < 0.6)
        heights = np.arange(STEP, max(goal.position[1] - floor - SEAT_TO_PELVIS, 2 * STEP), STEP)
        edge = np.full(len(heights), -np.inf)
        for k, height in enumerate(heights):
            slab = before & (np.abs(points[:, 1] - floor - height) < STEP)
            if slab.sum() > 5:
                edge[k] = np.percentile(ahead[slab], 98)
        return cls(heights, edge)

    def clear_shins(self, motion: Motion, goal: np.ndarray, standing: np.ndarray) -> Motion:
        """Move feet forward as far as shins and heels would otherwise be inside the object.

        The pelvis of a standing body moves with the feet, since the body would lean back otherwise; a seated one stays.
        goal: row of Route.goals, the seated pelvis. standing: (T,) shares, 1 upright and 0 seated. The floor of the
        motion is at height 0.
        """
        positions, _ = motion.forward_kinematics()
        facing, away = goal[3:6], positions[:, 0] - goal[:3]
        across = positions[:, 1] - positions[:, 2]
        turned = np.column_stack([-across[:, 2], across[:, 0]]) @ facing[[0, 2]] > 0.5 * np.linalg.norm(
            across, axis=-1
        )
        near = turned & (np.linalg.norm(away[:, [0, 2]], axis=-1) < CLOSE)
        legs = {side: self._leg(positions, side) for side in ("right", "left")}
        missing = {side: np.where(near, self._missing(*leg, goal), 0.0) for side, leg in legs.items()}
        if not any(forward.any() for forward in missing.values()):
            return motion
        forward = {side: anticipate(values, WINDOW, SIGMA) for side, values in missing.items()}
        along = standing * np.maximum(*forward.values())
        root, rotations = motion.root + along[:, None] * facing, motion.rotations
        for side, (_, ankle) in legs.items():
            target = ankle + np.maximum(forward[side], along)[:, None] * facing
            rotations = solve_limb(root, rotations, motion.rest_joints, f"{side}_leg", target)
        return replace(motion, root=root, rotations=rotations)

    @staticmethod
    def _leg(positions: np.ndarray, side: str) -> tuple[np.ndarray, np.ndarray]:
        """Return knee and ankle (T, 3) of a leg. positions: (T, J, 3)."""
        return tuple(positions[:, skeleton.INDEX[f"{side}_{name}"]] for name in ("knee", "ankle"))

    def _missing(self, knee: np.ndarray, ankle: np.ndarray, goal: np.ndarray) -> np.ndarray:
        """Return the metres (T,) by which an ankle has to move forward for its shin to clear the front."""
        along = (self.heights[None] - ankle[:, 1:2]) / np.maximum(knee[:, 1] - ankle[:, 1], 0.05)[:, None]
        # Towards the knee the lever of the ankle grows without bound; there the calf may rest on the edge.
        counted = along < 0.75
        along = np.clip(along, 0.0, 0.75)
        ankle_ahead, knee_ahead = ((p - goal[:3]) @ goal[3:6] for p in (ankle, knee))
        shin = ankle_ahead[:, None] + along * (knee_ahead - ankle_ahead)[:, None]
        missing = np.where(counted, (self.edge + SHIN - shin) / (1 - along), 0.0)
        return np.clip(missing.max(1, initial=0.0), 0.0, MAX_FORWARD)
