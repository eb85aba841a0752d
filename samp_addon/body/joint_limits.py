"""How far joints turn, by what captured people do."""

from __future__ import annotations

import numpy as np

from .. import skeleton

# Degrees from the zero pose: what the captured people reach in 999 of 1000 frames, and some more.
LIMITS = {"hip": 145, "knee": 160, "ankle": 80, "foot": 60, "spine1": 60, "spine2": 50, "spine3": 45, "neck": 75,
          "collar": 40, "head": 90, "shoulder": 140, "elbow": 160, "wrist": 120}  # fmt: skip


def limits() -> np.ndarray:
    """The largest angle (22,) of each body joint from its zero pose, radians; the pelvis turns freely."""
    found = np.full(skeleton.BODY_COUNT, np.pi)
    for name, degrees in LIMITS.items():
        for side in ("", "left_", "right_"):
            if side + name in skeleton.INDEX:
                found[skeleton.INDEX[side + name]] = np.radians(degrees)
    return found
