"""Consistent outward orientation of faces, for artists' meshes that are flipped, partly flipped, nested or open.

Triangles that share an edge form a patch and are oriented alike. A closed patch is oriented so that its volume is
positive; an open one keeps the orientation of most of its area unless it clearly bulges the other way. Network frame,
metres.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components

from ..geometry import area_vectors

WELD = 1e-5
"""Metres. Corners closer than this are merged to one vertex."""

HASH_FACTORS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)

BULGE = 0.02
"""Least ratio of the volume about the centroid to area^1.5 for an open patch to have a clear outside: 0.07 for a half
sphere and for a cube without a side."""


def orient_outward(triangles: np.ndarray) -> np.ndarray:
    """Return triangles (F, 3, 3) of which those that face inwards are flipped."""
    if len(triangles) == 0:
        return triangles
    corners = _welded(triangles)
    pairs, agree, closed_edges = _neighbours(corners)
    count = len(triangles)
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(count, count)).tocsr()
    patches, patch = connected_components(graph, directed=False)
    flip = _parity(graph, pairs, agree, patches, patch)
    area = area_vectors(triangles) * np.where(flip, -1.0, 1.0)[:, None]
    flip ^= _inside_out(triangles, area, flip, patch, patches, closed_edges)[patch]
    return np.where(flip[:, None, None], triangles[:, ::-1], triangles)


def _welded(triangles: np.ndarray) -> np.ndarray:
    """Return vertex indices (F, 3), equal for corners that coincide."""
    cells = np.round(triangles.reshape(-1, 3) / WELD).astype(np.int64).astype(np.uint64)
    # One hash per cell sorts ten times as fast as three numbers; a collision occurs in one of a billion scenes.
    keys = (cells * HASH_FACTORS).sum(1, dtype=np.uint64)
    _, index = np.unique(keys, return_inverse=True)
    return index.reshape(-1, 3)


def _neighbours(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Find the triangles that share an edge with exactly one other.

    Return pairs (N, 2) of triangles, whether the orientations of each pair agree (N,), and the number of such edges of
    each triangle (F,).
    """
    start, end = corners.reshape(-1), np.roll(corners, -1, axis=1).reshape(-1)
    owner = np.repeat(np.arange(len(corners)), 3)
    proper = start != end
    start, end, owner = start[proper], end[proper], owner[proper]
    low, high = np.minimum(start, end), np.maximum(start, end)
    key = low * (int(corners.max()) + 1) + high
    order = np.argsort(key, kind="stable")
    key, owner, forward = key[order], owner[order], (start == low)[order]
    first = np.flatnonzero(np.r_[True, key[1:] != key[:-1]])
    size = np.diff(np.r_[first, len(key)])
    two = first[size == 2]
    pairs = np.stack([owner[two], owner[two + 1]], -1)
    agree = forward[two] != forward[two + 1]
    shared = np.bincount(pairs.reshape(-1), minlength=len(corners))
    return pairs, agree, shared


def _parity(
    graph: coo_matrix, pairs: np.ndarray, agree: np.ndarray, patches: int, patch: np.ndarray
) -> np.ndarray:
    """Flag the triangles (F,) to flip so that all of a patch agree with its first."""
    flip = np.zeros(len(patch), bool)
    mixed = np.unique(patch[pairs[~agree, 0]])
    if len(mixed) == 0:
        return flip
    count = len(patch)
    both = np.concatenate([pairs, pairs[:, ::-1]])
    sign = np.where(np.concatenate([agree, agree]), 1, -1)
    signs = coo_matrix((sign, both.T), shape=(count, count)).tocsr()
    firsts = np.full(patches, count)
    np.minimum.at(firsts, patch, np.arange(count))
    for label in mixed:
        order, predecessor = breadth_first_order(graph, firsts[label], directed=False)
        sign_along = np.asarray(signs[predecessor[order[1:]], order[1:]]).ravel()
        for triangle, parent, sign_ in zip(order[1:], predecessor[order[1:]], sign_along, strict=True):
            flip[triangle] = flip[parent] ^ (sign_ < 0)
    return flip


def _inside_out(
    triangles: np.ndarray,
    area: np.ndarray,
    flip: np.ndarray,
    patch: np.ndarray,
    patches: int,
    shared: np.ndarray,
) -> np.ndarray:
    """Flag the patches (P,) that face inwards. area: (F, 3) area vectors of the consistently oriented triangles."""
    size = np.linalg.norm(area, axis=-1)
    whole = np.bincount(patch, size, patches)
    middle = triangles.mean(1)
    centre = np.stack([np.bincount(patch, size * middle[:, k], patches) for k in range(3)], -1)
    centre /= np.maximum(whole, 1e-12)[:, None]
    volume = np.bincount(patch, ((middle - centre[patch]) * area).sum(-1) / 3, patches)
    closed = np.bincount(patch, shared != 3, patches) == 0
    clear = closed | (np.abs(volume) > BULGE * whole**1.5)
    turned = np.bincount(patch, np.where(flip, size, 0.0), patches) > 0.5 * whole
    return np.where(clear, volume < 0, turned)
