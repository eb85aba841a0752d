"""Bodies that lie on their back with the head and the chest in the air, as if sitting up: the spine is laid down.

One in seven rollouts stops so on a flat bed, with the pelvis flat and the spine bent. Network frame, metres.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .... import rotation, skeleton
from ....easing import smoothstep
from ....motion import Motion

RAISED = 0.6
"""Cosine between chest and vertical above which a body at rest does not lie; as of the rollout (tracking.RECLINED)."""

FLAT = 0.12
"""The same of a body that is laid down."""

SPINE = tuple(skeleton.INDEX[name] for name in ("spine1", "spine2", "spine3", "neck", "head"))
CHEST = skeleton.INDEX["spine3"]
LAYING, STILL = 45, 0.15
"""Frames at 30 fps in which the spine is laid down, and metres from its place at the end within which the pelvis is
then."""


def uncurled(motion: Motion) -> Motion:
    """Return the motion with the spine laid down in its rest, if its chest is in the air there."""
    if _upright(motion, 0.0) <= RAISED:
        return motion
    enough = next((share for share in np.linspace(0.05, 1.0, 20) if _upright(motion, share) <= FLAT), 1.0)
    away = np.flatnonzero(np.linalg.norm(motion.root - motion.root[-1], axis=-1) > STILL)
    rests = int(away[-1]) + 1 if len(away) else 0
    weight = smoothstep((np.arange(len(motion)) - rests) / LAYING)
    return replace(motion, rotations=_straightened(motion.rotations, weight * enough))


def _upright(motion: Motion, share: float) -> float:
    """Return the cosine between chest and vertical in the last frame, with a share of the bend taken out."""
    last = motion.pose_slice(slice(-1, None))
    turned = replace(last, rotations=_straightened(last.rotations, np.array([share])))
    return float(rotation.uprightness(turned.forward_kinematics()[1][0, CHEST]))


def _straightened(rotations: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Return rotations (T, J, 4) with shares (T,) of the bend of the spine taken out."""
    turned = rotations.copy()
    straight = np.broadcast_to([1.0, 0.0, 0.0, 0.0], rotations[:, SPINE].shape)
    turned[:, SPINE] = rotation.slerp(rotations[:, SPINE], straight, share[:, None])
    return turned
