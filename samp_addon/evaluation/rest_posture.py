"""The posture of a body at rest, by the words of vocabulary.POSTURES. Network frame, metres.

The same measurements label the training data and judge whether a take rests as asked.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..body import human
from ..body.human import Human
from ..motion import Motion
from ..skeleton import INDEX
from ..vocabulary import POSTURE_NAMES

LEANING = 4.0
"""Degrees backward of vertical, hips to neck, from which a seated trunk leans back; less is upright."""

SLUMPED = -12.0
"""Degrees backward of vertical below which a seated trunk is bent forward, and neither upright nor leaning back."""

ON_THIGH = 0.155
"""Metres from a wrist to the axis of a thigh within which the hand lies on it."""

BESIDE = (0.21, 0.45)
"""Metres sideways from the pelvis to a wrist that lies on an armrest."""

ARMREST_HEIGHT = (-0.02, 0.24)
"""Metres from the pelvis up to a wrist that lies on an armrest."""

TABLE_FORWARD, TABLE_HEIGHT = 0.24, (0.06, 0.36)
"""Metres in front of the pelvis, at least, and above it, of wrists that lie on a table."""

CROSSED = 0.03
"""Metres by which a foot is on the other foot's side when ankles or legs are crossed."""

RAISED_FOOT = 0.2
"""Metres between the heights of the ankles from which one leg lies over the other."""

SIDEWAYS = 0.6
"""Vertical part of the unit vector from hip to hip from which a lying body is on its side."""

RAISED_TRUNK = 18.0
"""Degrees between a lying body's trunk and the floor from which it is half sitting."""


TOUCHING_BACK = 0.03
"""Metres from the skin of the back to the seat's up to which a body leans on it: clothes and cushions yield."""

BACK_ABOVE, BACK_BEHIND, BACK_ASIDE = 0.10, 0.45, 0.2
"""Metres over, behind and aside of the pelvis in which a seat has a back."""

LEAST_BACK_SHARE = 1 / 800
"""Share of the seat's points on its back below which it counts as having none."""


def flags(motion: Motion, action: str) -> dict[str, np.ndarray]:
    """Return flags (T,) for each posture of an action of the body in each frame; none for actions without a rest."""
    measured = {"sit": _seated, "lie": _lying}.get(action)
    return measured(_Points(motion)) if measured else {}


def shares(motion: Motion, action: str, frames: np.ndarray) -> np.ndarray:
    """Return the share of ``frames`` in each posture, in the order of POSTURE_NAMES; zeros for other actions."""
    found = flags(motion, action)
    return np.array([found[name][frames].mean() if name in found else 0.0 for name in POSTURE_NAMES])


def back_gap(motion: Motion, frame: int, points: np.ndarray, body: Human | None = None) -> float | None:
    """Return the metres from the upper back to the back of a seat in one frame; None where the seat has no back.

    points: (N, 3) on the seat's surface, thousands. body: the default human if left out.
    """
    body = body or human.load()
    still = motion.pose_slice(slice(frame, frame + 1))
    away, ahead = points - still.root[0], still.headings()[0]
    behind = -(away @ ahead)
    aside = np.abs(away @ np.cross([0.0, 1.0, 0.0], ahead))
    back = points[(away[:, 1] > BACK_ABOVE) & (behind > 0) & (behind < BACK_BEHIND) & (aside < BACK_ASIDE)]
    if len(back) < max(LEAST_BACK_SHARE * len(points), 1):
        return None
    return float(cKDTree(back).query(human.skin(body, still, human.back_of(body))[0])[0].min())


class _Points:
    """Joints relative to the pelvis in the body's heading: x to its left, y up, z forward."""

    def __init__(self, motion: Motion) -> None:
        joints = motion.forward_kinematics()[0]
        ahead = motion.headings()
        self._ahead, self._left = ahead, np.cross([0.0, 1.0, 0.0], ahead)
        self._joints = joints - joints[:, :1]

    def __call__(self, name: str) -> np.ndarray:
        """Place (T, 3) of a joint."""
        away = self._joints[:, INDEX[name]]
        return np.stack([(away * self._left).sum(-1), away[:, 1], (away * self._ahead).sum(-1)], -1)

    def both(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Places (T, 3) of the left and of the right joint of a name."""
        return self(f"left_{name}"), self(f"right_{name}")


def _seated(points: _Points) -> dict[str, np.ndarray]:
    trunk = points("neck") - (points("left_hip") + points("right_hip")) / 2
    tilt = np.degrees(np.arctan2(-trunk[:, 2], trunk[:, 1]))
    wrists, ankles = points.both("wrist"), points.both("ankle")
    lap = np.all([_to_thighs(points, wrist) < ON_THIGH for wrist in wrists], axis=0)
    resting = [
        _within(np.abs(w[:, 0]), BESIDE)
        & _within(w[:, 1], ARMREST_HEIGHT)
        & (_to_thighs(points, w) >= ON_THIGH)
        for w in wrists
    ]
    table = (
        np.all([(w[:, 2] > TABLE_FORWARD) & _within(w[:, 1], TABLE_HEIGHT) for w in wrists], axis=0) & ~lap
    )
    apart = ankles[0][:, 0] - ankles[1][:, 0]
    return {
        "upright": (tilt < LEANING) & (tilt >= SLUMPED),
        "lean_back": tilt >= LEANING,
        "hands_on_lap": lap,
        "hands_on_armrests": np.any(resting, axis=0) & ~table,
        "hands_on_table": table,
        "legs_crossed": (apart < -CROSSED) | (np.abs(ankles[0][:, 1] - ankles[1][:, 1]) > RAISED_FOOT),
    }


def _lying(points: _Points) -> dict[str, np.ndarray]:
    left, right = points.both("hip")
    across, trunk = left - right, points("neck") - (left + right) / 2
    sideways = np.abs(across[:, 1]) / np.linalg.norm(across, axis=-1) > SIDEWAYS
    raised = (
        np.degrees(np.arcsin(np.clip(trunk[:, 1] / np.linalg.norm(trunk, axis=-1), -1, 1))) > RAISED_TRUNK
    )
    return {"on_back": ~sideways & ~raised, "on_side": sideways, "half_sitting": raised & ~sideways}


def _to_thighs(points: _Points, wrist: np.ndarray) -> np.ndarray:
    """Distances (T,) of places (T, 3) to the nearer thigh."""
    distances = []
    for hip, knee in zip(points.both("hip"), points.both("knee"), strict=True):
        along = knee - hip
        share = np.clip(((wrist - hip) * along).sum(-1) / (along**2).sum(-1), 0, 1)
        distances.append(np.linalg.norm(wrist - hip - share[:, None] * along, axis=-1))
    return np.min(distances, axis=0)


def _within(values: np.ndarray, bounds: tuple[float, float]) -> np.ndarray:
    return (values >= bounds[0]) & (values <= bounds[1])
