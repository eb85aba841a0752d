"""The type of a piece of furniture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Piece:
    """One piece of furniture.

    category: one of generate.CATEGORIES or of the library's. triangles: (F, 3, 3) metres, network frame, front +Z,
    standing on y = 0. name: unique within its source.
    """

    category: str
    triangles: np.ndarray
    name: str
