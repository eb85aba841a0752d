"""How corrections fade in and out."""

from __future__ import annotations

import numpy as np


def smoothstep(t: np.ndarray) -> np.ndarray:
    """0 up to t = 0, 1 from t = 1, with no velocity at either end."""
    t = np.clip(t, 0.0, 1.0)
    return t * t * (3 - 2 * t)
