"""Eyebrows: faces of the skin over the eyes that have the colour of the hair. Network frame, metres, T-pose."""

from __future__ import annotations

import numpy as np

from .. import skeleton

INNER, OUTER = 0.015, 0.022
"""Horizontal extent of a brow from above the joint of the eye: towards the nose, and towards the temple."""
HIGH = 0.0187
"""Height of its centre line over that joint, on the side of the nose."""
FALL = 13.0
"""Per metre: towards the temple the centre line falls by FALL times the square of the distance from above the joint."""
HALF = 0.0025
"""Half of its height."""


def of(vertices: np.ndarray, faces: np.ndarray, joints: np.ndarray) -> np.ndarray:
    """Return which faces (F,) are brows, for vertices (V, 3), faces (F, 4) and joints (55, 3)."""
    centres = vertices[faces].mean(axis=1)
    found = np.zeros(len(faces), dtype=bool)
    for side, outward in (("left", 1.0), ("right", -1.0)):
        across, up, ahead = (centres - joints[skeleton.INDEX[f"{side}_eye_smplhf"]]).T
        out = outward * across
        line = HIGH - FALL * np.maximum(out, 0.0) ** 2
        found |= (out > -INNER) & (out < OUTER) & (np.abs(up - line) < HALF) & (ahead > 0.0)
    return found
