"""A single body in the scene, and batches of them as Motions. Network frame, metres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ... import rotation, skeleton
from ...body import betas as shapes
from ...body import hand_poses
from ...motion import Motion


@dataclass(frozen=True)
class Figure:
    """A posed body.

    root: (3,) world position of the pelvis joint. rotations: (22, 4) local quaternions. hands: (24,) see
    body/hand_poses.py. betas: (10,) see body/betas.py. level: height of the floor under it.
    """

    root: np.ndarray
    rotations: np.ndarray
    hands: np.ndarray
    betas: np.ndarray
    level: float = 0.0

    @property
    def yaw(self) -> float:
        """The facing in radians: perpendicular to the pelvis' left side."""
        matrix = rotation.quaternion_to_matrix(self.rotations[0])
        return float(np.arctan2(-matrix[2, 0], matrix[0, 0]))

    def facing(self, action: str) -> float:
        """Return the facing in radians of a body in an action: of a lying one, from its head to its feet."""
        if action != "lie":
            return self.yaw
        matrix = rotation.quaternion_to_matrix(self.rotations[0])
        return float(np.arctan2(-matrix[0, 1], -matrix[2, 1]))

    @property
    def joints(self) -> np.ndarray:
        """World positions (22, 3) of the joints."""
        rest = shapes.body_of(self.betas).joints
        return skeleton.forward_kinematics(self.root[None], self.rotations[None], rest)[0][0]

    def moved(self, shift: np.ndarray) -> Figure:
        """Return the figure moved by (3,)."""
        return Figure(self.root + shift, self.rotations, self.hands, self.betas, self.level)


def as_motion(figures: Sequence[Figure]) -> Motion:
    """Return figures of the same shape as the frames of a Motion with hands."""
    turns = np.array([figure.rotations for figure in figures])
    return Motion(
        np.array([figure.root for figure in figures]),
        hand_poses.with_hands(turns, np.array([figure.hands for figure in figures])),
        rest_joints=shapes.body_of(figures[0].betas).joints,
    )
