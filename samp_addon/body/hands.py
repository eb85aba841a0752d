"""Relaxed hands for takes, which move only the 22 body joints: flat fingers look like a mannequin's."""

from __future__ import annotations

import functools

import numpy as np

from .. import rotation, skeleton

# Right hand, degrees: flexion of the three joints of each finger of a relaxed hand, and the rotation at its root that
# closes the spread fingers of the T-pose.
_BEND = {"index": (14, 24, 14), "middle": (18, 28, 16), "ring": (22, 30, 17), "pinky": (25, 30, 17)}
_CLOSE = {"index": -6, "middle": -1, "ring": 4, "pinky": 9}
# The thumb rests against the index finger.
_THUMB = ((8, -24, 16), (0, -8, 6), (0, -12, 6))


@functools.cache
def relaxed_hands() -> np.ndarray:
    """Return local quaternions (33, 4) of joints 22 to 54 (jaw, eyes, fingers) of a relaxed body; read-only."""
    tail = skeleton.JOINTS[skeleton.BODY_COUNT :]
    result = np.tile([1.0, 0.0, 0.0, 0.0], (len(tail), 1))
    for i, name in enumerate(tail):
        side, _, finger = name.partition("_")
        # In the T-pose fingers lie along x, palms down: the left hand closes about -z, the right about +z.
        mirror = np.array([1.0, -1.0, -1.0]) if side == "left" else np.ones(3)
        if finger[:-1] in _BEND:
            k = int(finger[-1]) - 1
            bend = np.array([0.0, _CLOSE[finger[:-1]] if k == 0 else 0.0, _BEND[finger[:-1]][k]])
        elif finger[:-1] == "thumb":
            bend = np.array(_THUMB[int(finger[-1]) - 1], dtype=float)
        else:
            continue
        result[i] = rotation.from_axis_angle(np.radians(bend * mirror))
    result.setflags(write=False)
    return result


def complete(rotations: np.ndarray) -> np.ndarray:
    """Extend local rotations (T, J, 4) of J >= 22 joints to all 55, (T, 55, 4), with relaxed hands and face."""
    frames, count = rotations.shape[:2]
    tail = relaxed_hands()[count - skeleton.BODY_COUNT :]
    return np.concatenate([rotations, np.broadcast_to(tail, (frames, *tail.shape))], axis=1)
