"""Simple meshes for tests."""

from __future__ import annotations

import numpy as np


def box(low, high):
    """Return the triangles (12, 3, 3) of a box."""
    corners = np.array(
        [[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    )
    faces = [
        (0, 1, 3),
        (0, 3, 2),
        (4, 6, 7),
        (4, 7, 5),
        (0, 4, 5),
        (0, 5, 1),
        (2, 3, 7),
        (2, 7, 6),
        (0, 2, 6),
        (0, 6, 4),
    ]
    return corners[np.array([*faces, (1, 5, 7), (1, 7, 3)])].astype(float)
