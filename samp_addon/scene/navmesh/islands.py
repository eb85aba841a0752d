"""Connected parts of the ground, and which of them are only the tops of furniture."""

from __future__ import annotations

import numpy as np

from .ground import DIRECTIONS, LARGEST_TOP, Ground, connected, pairs

SMALLEST = 0.3
"""Square metres of walkable ground. Smaller parts are dropped."""
HIGHEST_TOP = 1.6
"""Metres. What is higher over the ground beside it is no furniture that one could mistake for floor."""
OPEN_EDGE = 0.05
"""Share of a part's edge from which one looks down onto ground, beyond which it counts as furniture."""
LOOK = 3
"""Columns beyond the edge in which lower ground is looked for."""


def prune(ground: Ground, walkable: np.ndarray, step: float) -> np.ndarray:
    """The walkable places (N,) flags less small parts and furniture's tops; the largest part stays."""
    chosen = pairs(ground.links, walkable)
    label = connected(len(walkable), chosen)
    size = np.bincount(label[walkable], minlength=int(label.max(initial=0)) + 1)
    enough = size * ground.grid.cell**2 >= SMALLEST
    enough[size.argmax()] = True
    top = _furniture_tops(ground, step)
    top &= label != size.argmax()
    return walkable & enough[label] & ~top


def _furniture_tops(ground: Ground, step: float) -> np.ndarray:
    """Flags (N,): places on a part that nothing leads onto and that rises over the ground beside it."""
    label = connected(len(ground.places), pairs(ground.links))
    edge, above = np.zeros((2, len(ground.places)), dtype=int)
    for direction in range(4):
        here = np.flatnonzero(ground.links[direction] < 0)
        edge[here] += 1
        above[here] += _looks_down(ground, here, DIRECTIONS[direction], step)
    parts = int(label.max(initial=0)) + 1
    area = np.bincount(label, minlength=parts) * ground.grid.cell**2
    edges, downs = np.bincount(label, edge, parts), np.bincount(label, above, parts)
    return ((area <= LARGEST_TOP) & (downs > OPEN_EDGE * edges))[label]


def _looks_down(ground: Ground, here: np.ndarray, direction: np.ndarray, step: float) -> np.ndarray:
    """Flags (K,): ground lies a few columns away from places (K,), lower by a furniture's height."""
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
