"""Hands at rest: a take moves the 22 body joints; fingers that stay flat look like a mannequin's."""

from __future__ import annotations

import functools

import numpy as np

from .. import rotation, skeleton

# Bend of the three joints of each finger in degrees, as hands hang when nobody thinks of them.
_BEND = {"index": (12, 22, 12), "middle": (18, 26, 14), "ring": (22, 28, 15), "pinky": (24, 28, 15)}
# The thumb lies along the forefinger: turned in about the finger axis, then bent.
_THUMB = ((10, 12, -8), (0, 10, -6), (0, 12, -4))


@functools.cache
def relaxed_hands() -> np.ndarray:
    """Local quaternions (33, 4) of the joints 22 to 54 (jaw, eyes, fingers) of a relaxed body. Read-only."""
    tail = skeleton.JOINTS[skeleton.BODY_COUNT :]
    result = np.tile([1.0, 0.0, 0.0, 0.0], (len(tail), 1))
    for i, name in enumerate(tail):
        side, _, finger = name.partition("_")
        # In the T-pose fingers lie along x, palms down: closing the left hand turns about -z, the right about +z.
        mirror = np.array([1.0, -1.0, -1.0]) if side == "left" else np.ones(3)
        if finger[:-1] in _BEND:
            bend = np.array([0.0, 0.0, _BEND[finger[:-1]][int(finger[-1]) - 1]])
        elif finger[:-1] == "thumb":
            bend = np.array(_THUMB[int(finger[-1]) - 1], dtype=float)
        else:
            continue
        result[i] = rotation.from_axis_angle(np.radians(bend * mirror))
    result.setflags(write=False)
    return result


def complete(rotations: np.ndarray) -> np.ndarray:
    """Local rotations (T, J, 4) of J >= 22 joints with the missing ones of the 55 relaxed: (T, 55, 4)."""
    frames, count = rotations.shape[:2]
    tail = relaxed_hands()[count - skeleton.BODY_COUNT :]
    return np.concatenate([rotations, np.broadcast_to(tail, (frames, *tail.shape))], axis=1)
