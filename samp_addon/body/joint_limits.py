"""Joint limits from captured motion."""

from __future__ import annotations

import numpy as np

from .. import skeleton

# Degrees from the zero pose: the 99.9th percentile of captured motion, and a margin.
LIMITS = {"hip": 145, "knee": 160, "ankle": 80, "foot": 60, "spine1": 60, "spine2": 50, "spine3": 45, "neck": 75,
          "collar": 40, "head": 90, "shoulder": 140, "elbow": 160, "wrist": 120}  # fmt: skip


def limits() -> np.ndarray:
    """Return the largest angle (22,) of each body joint from the zero pose, radians; the pelvis is not limited."""
    result = np.full(skeleton.BODY_COUNT, np.pi)
    for name, degrees in LIMITS.items():
        for side in ("", "left_", "right_"):
            if side + name in skeleton.INDEX:
                result[skeleton.INDEX[side + name]] = np.radians(degrees)
    return result
