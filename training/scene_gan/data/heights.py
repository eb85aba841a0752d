"""Height maps of whole rooms seen from above, for the bird's-eye variant."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from ....models.scene_gan.height_map import HIGHEST
from ....samp_addon.scene import geometry
from .units import HEIGHT_CELL, HEIGHT_UNIT, NOTHING

POINTS = 400_000
HOLES = 1.5  # distance in cells up to which empty cells get the height of the nearest known one
SIDE = 168  # cells: 8.4 m


def grid(triangles: np.ndarray, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Return the heights (SIDE, SIDE) uint8 of the highest surface under HIGHEST, and the lowest corner (2,).

    Heights are in HEIGHT_UNIT. triangles: (F, 3, 3) of a room whose floor is at height 0. NOTHING where no surface is.
    """
    points, _ = geometry.sample_surface(triangles, POINTS, seed=seed)
    points = points[(points[:, 1] > -0.1) & (points[:, 1] < HIGHEST)]
    corner = np.full(2, -SIDE * HEIGHT_CELL / 2)
    cells = np.floor((points[:, [0, 2]] - corner) / HEIGHT_CELL).astype(int)
    inside = ((cells >= 0) & (cells < SIDE)).all(-1)
    cells, height = cells[inside], np.clip(points[inside, 1], 0, None)
    out = np.full((SIDE, SIDE), -1.0)
    np.maximum.at(out, (cells[:, 0], cells[:, 1]), height)
    # Fill cells that the samples miss.
    far, nearest = ndimage.distance_transform_edt(out < 0, return_indices=True)
    out = np.where(far <= HOLES, out[tuple(nearest)], out)
    return np.where(out < 0, NOTHING, np.round(out / HEIGHT_UNIT)).astype(np.uint8), corner
