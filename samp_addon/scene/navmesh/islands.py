"""Removal of ground that is too small, or only the top of furniture."""

from __future__ import annotations

import numpy as np

from .ground import DIRECTIONS, LARGEST_TOP, Ground, connected, pairs

SMALLEST = 0.3
"""Square metres. Smaller connected parts of the walkable ground are removed."""
HIGHEST_TOP = 1.6
"""Metres over the adjacent ground, above which a part is not considered furniture."""
OPEN_EDGE = 0.05
"""A part counts as furniture if lower ground is adjacent to more than this share of its edge."""
LOOK = 3
"""Columns beyond the edge that are searched for lower ground."""


def prune(ground: Ground, walkable: np.ndarray, step: float) -> np.ndarray:
    """Remove small parts and tops of furniture from the walkable places (N,) flags; the largest part is kept."""
    chosen = pairs(ground.links, walkable)
    label = connected(len(walkable), chosen)
    size = np.bincount(label[walkable], minlength=int(label.max(initial=0)) + 1)
    enough = size * ground.grid.cell**2 >= SMALLEST
    enough[size.argmax()] = True
    top = _furniture_tops(ground, step)
    top &= label != size.argmax()
    return walkable & enough[label] & ~top


def _furniture_tops(ground: Ground, step: float) -> np.ndarray:
    """Flag the places (N,) on small parts that rise over the adjacent ground without a way up."""
    label = connected(len(ground.places), pairs(ground.links))
    edge, open_edge = np.zeros((2, len(ground.places)), dtype=int)
    for direction in range(4):
        here = np.flatnonzero(ground.links[direction] < 0)
        edge[here] += 1
        open_edge[here] += _has_lower_ground(ground, here, DIRECTIONS[direction], step)
    parts = int(label.max(initial=0)) + 1
    area = np.bincount(label, minlength=parts) * ground.grid.cell**2
    edges, open_edges = np.bincount(label, edge, parts), np.bincount(label, open_edge, parts)
    return ((area <= LARGEST_TOP) & (open_edges > OPEN_EDGE * edges))[label]


def _has_lower_ground(ground: Ground, here: np.ndarray, direction: np.ndarray, step: float) -> np.ndarray:
    """Flag the places (K,) with ground a few columns away that is lower, by ``step`` to HIGHEST_TOP."""
    found = np.zeros(len(here), dtype=bool)
    places, shape = ground.places, ground.grid.shape
    for columns in range(1, LOOK + 1):
        x = np.clip(places.x[here] + columns * direction[0], 0, shape[0] - 1)
        z = np.clip(places.z[here] + columns * direction[1], 0, shape[1] - 1)
        for layer in ground.index:
            other = layer[x, z]
            drop = places.height[here] - places.height[other]
            found |= (other >= 0) & (drop > step) & (drop < HIGHEST_TOP)
    return found
