"""The feet of a body: their joints, soles and toes. Network frame, metres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ... import rotation, skeleton
from ...vocabulary import CONTACTS

BALL_HEIGHT = 0.0276  # of the ball joint over the sole, default human
HEEL_BACK = 0.045  # from the ankle joint to the heel
TOE_AHEAD = 0.06  # from the ball joint to the tip of the toes


@dataclass(frozen=True)
class Foot:
    """One foot: its side, its column in Motion.contacts, and the indices of its joints."""

    side: str
    column: int

    @property
    def ankle(self) -> int:
        return skeleton.INDEX[f"{self.side}_ankle"]

    @property
    def ball(self) -> int:
        return skeleton.INDEX[f"{self.side}_foot"]

    @property
    def knee(self) -> int:
        return skeleton.INDEX[f"{self.side}_knee"]

    @property
    def hip(self) -> int:
        return skeleton.INDEX[f"{self.side}_hip"]


FEET = tuple(Foot(side, CONTACTS.index(f"{side}_foot")) for side in ("right", "left"))


def sole_offsets(rest_joints: np.ndarray, side: str) -> tuple[np.ndarray, np.ndarray]:
    """Return heel and ball of the sole, each (3,), in the frame of the ankle joint of the rest pose."""
    ankle, ball = rest_joints[skeleton.INDEX[f"{side}_ankle"]], rest_joints[skeleton.INDEX[f"{side}_foot"]]
    along = _along(rest_joints, side)
    down = np.array([0.0, ball[1] - BALL_HEIGHT - ankle[1], 0.0])
    return down - HEEL_BACK * (along / np.linalg.norm(along)), ball - ankle - [0.0, BALL_HEIGHT, 0.0]


def sole_points(
    positions: np.ndarray, globals_: np.ndarray, rest_joints: np.ndarray, side: str
) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest points of heel and ball, each (T, 3).

    positions: (T, J, 3) of the joints. globals_: (T, J, 4) global quaternions.
    """
    ankle, ball = skeleton.INDEX[f"{side}_ankle"], skeleton.INDEX[f"{side}_foot"]
    heel, _ = sole_offsets(rest_joints, side)
    heel_world = positions[:, ankle] + rotation.rotate(
        globals_[:, ankle], np.broadcast_to(heel, positions[:, ankle].shape)
    )
    return heel_world, positions[:, ball] - np.array([0.0, BALL_HEIGHT, 0.0])


def toe_tips(positions: np.ndarray, globals_: np.ndarray, rest_joints: np.ndarray, side: str) -> np.ndarray:
    """Return the tip of the toes (T, 3), at the height of the sole.

    positions: (T, J, 3) of the joints. globals_: (T, J, 4) global quaternions.
    """
    ball = skeleton.INDEX[f"{side}_foot"]
    along = _along(rest_joints, side)
    tip = TOE_AHEAD * along / np.linalg.norm(along) - np.array([0.0, BALL_HEIGHT, 0.0])
    return positions[:, ball] + rotation.rotate(
        globals_[:, ball], np.broadcast_to(tip, positions[:, ball].shape)
    )


def _along(rest_joints: np.ndarray, side: str) -> np.ndarray:
    """Return the horizontal vector (3,) from ankle to ball in the rest pose."""
    ankle, ball = rest_joints[skeleton.INDEX[f"{side}_ankle"]], rest_joints[skeleton.INDEX[f"{side}_foot"]]
    return (ball - ankle) * np.array([1.0, 0.0, 1.0])
