"""Connected parts of the ground, and which of them are only the tops of furniture."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from .ground import DIRECTIONS, Ground

SMALLEST = 0.3
"""Square metres of walkable ground. Smaller parts are dropped."""
LARGEST_TOP = 8.0
"""Square metres. A larger raised part is a stage or a storey, not a bed or a table."""
HIGHEST_TOP = 1.6
"""Metres. What is higher over the ground beside it is no furniture that one could mistake for floor."""
OPEN_EDGE = 0.05
"""Share of a part's edge from which one looks down onto ground, beyond which it counts as furniture."""
LOOK = 3
"""Columns beyond the edge in which lower ground is looked for."""


def worth_keeping(ground: Ground, walkable: np.ndarray, step: float) -> np.ndarray:
    """The walkable places (N,) flags less small parts and furniture's tops; the largest part stays."""
    chosen = _joined(ground, walkable)
    label = connected(len(walkable), chosen)
    size = np.bincount(label[walkable], minlength=int(label.max(initial=0)) + 1)
    enough = size * ground.grid.cell**2 >= SMALLEST
    enough[size.argmax()] = True
    top = _furniture_tops(ground, step)
    top &= label != size.argmax()
    return walkable & enough[label] & ~top


def connected(count: int, pairs: np.ndarray) -> np.ndarray:
    """Labels (count,) of the parts that pairs (K, 2) connect."""
    links = sparse.coo_matrix((np.ones(len(pairs), dtype=bool), tuple(pairs.T)), shape=(count, count))
    return csgraph.connected_components(links, directed=False)[1]


def _joined(ground: Ground, chosen: np.ndarray) -> np.ndarray:
    """Pairs (K, 2) of chosen places (N,) that can be stepped between."""
    pairs = []
    for direction in (0, 1):
        target = ground.links[direction]
        here = np.flatnonzero((target >= 0) & chosen & chosen[target])
        pairs.append(np.stack([here, target[here]], axis=1))
    return np.concatenate(pairs)


def _furniture_tops(ground: Ground, step: float) -> np.ndarray:
    """Flags (N,): places on a part that nothing leads onto and that rises over the ground beside it."""
    label = connected(len(ground.places), _joined(ground, np.ones(len(ground.places), dtype=bool)))
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
