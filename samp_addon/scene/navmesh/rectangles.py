"""Partition of the walkable places into few convex polygons, rectangles of cells, with portals between them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .ground import DIRECTIONS, Ground

AT_ONCE = 1024
"""Columns that are looked up together: most are in rectangles of earlier ones."""


@dataclass(frozen=True)
class Rectangles:
    """Convex pieces of the ground: every place of a piece is reachable from every other in a straight line.

    first, last: (P, 2) columns x, z of their corners, both inclusive. layer: (P,) of Ground.index.
    owner: (N,) the piece of each place, or -1. rough: (P,) flags of pieces on rough ground.
    """

    first: np.ndarray
    last: np.ndarray
    layer: np.ndarray
    owner: np.ndarray
    rough: np.ndarray

    def __len__(self) -> int:
        return len(self.first)


@dataclass(frozen=True)
class Portals:
    """Shared borders of pieces.

    pieces: (Q, 2) from, to. ends: (Q, 2, 3) metres; equal where only one cell touches. They are midpoints between cell
    centres, so that paths around them keep their clearance. axis: (Q,) of the crossing, 0 for x and 1 for z.
    """

    pieces: np.ndarray
    ends: np.ndarray
    axis: np.ndarray

    def __len__(self) -> int:
        return len(self.pieces)


def cover(ground: Ground, walkable: np.ndarray) -> Rectangles:
    """Cover the walkable places (N,) flags with rectangles, grown one by one from the most open places."""
    owner = np.full(len(ground.places), -1, dtype=np.int32)
    found: list[tuple[int, int, int, int, int]] = []
    order = np.lexsort((ground.places.z, ground.places.x, -np.round(ground.clearance / ground.grid.cell)))
    seeds = order[walkable[order]]
    layer_of = np.empty(len(ground.places), dtype=np.int32)
    for layer, numbers in enumerate(ground.index):
        layer_of[numbers[numbers >= 0]] = layer
    for layer, numbers in enumerate(ground.index):
        width = numbers.shape[1]
        # bytearray: searching a slice is ten times as fast as with a small array.
        steps = [bytearray(flags.tobytes()) for flags in _steps_inside(ground, walkable, numbers)]
        taken = bytearray(numbers.size)
        here = seeds[layer_of[seeds] == layer]
        for at in _left(ground.places.x[here] * width + ground.places.z[here], taken):
            if not taken[at]:
                x0, x1, z0, z1 = _grow(*steps, width, *divmod(at, width))
                for x in range(x0, x1 + 1):
                    taken[x * width + z0 : x * width + z1 + 1] = b"\1" * (z1 - z0 + 1)
                owner[numbers[x0 : x1 + 1, z0 : z1 + 1]] = len(found)
                found.append((layer, x0, z0, x1, z1))
    table = np.array(found, dtype=np.int64).reshape(-1, 5)
    layer, first, last = table[:, 0], table[:, 1:3], table[:, 3:5]
    rough = ground.rough[ground.index[layer, first[:, 0], first[:, 1]]]
    return Rectangles(first, last, layer, owner, rough)


def _left(columns: np.ndarray, taken: bytearray) -> Iterator[int]:
    """Yield the columns (K,) in their order, without most of those that are taken by then."""
    flags = np.frombuffer(taken, np.uint8)
    for first in range(0, len(columns), AT_ONCE):
        some = columns[first : first + AT_ONCE]
        yield from some[flags[some] == 0].tolist()


def _steps_inside(ground: Ground, walkable: np.ndarray, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Flag the columns (X, Z), for each of the directions x and z, whose next column continues the same ground."""
    here = np.flatnonzero(numbers.ravel() >= 0)
    place = numbers.ravel()[here]
    steps = []
    for direction in (0, 1):
        target = ground.smooth[direction, place]
        x, z = ground.places.x[place], ground.places.z[place]
        same = numbers[x + DIRECTIONS[direction][0], z + DIRECTIONS[direction][1]] == target
        good = (target >= 0) & same & walkable[place] & walkable[target]
        good &= ground.rough[place] == ground.rough[target]
        flags = np.zeros(numbers.size, dtype=bool)
        flags[here] = good
        steps.append(flags.reshape(numbers.shape))
    return steps[0], steps[1]


def _grow(along_x: bytearray, along_z: bytearray, width: int, x: int, z: int) -> tuple[int, int, int, int]:
    """Grow a rectangle from a cell, one side after the other; return its bounds x0, x1, z0, z1, inclusive.

    The tables of steps hold one byte for each column x * width + z; those of the rectangle are cleared.
    """
    x0 = x1 = x
    z0 = z1 = z
    # Written out without calls, since a room needs tens of thousands of these tests. Empty ranges are passable.
    in_x, in_z = along_x.find, along_z.find
    up = down = left = right = True
    while up or down or left or right:
        columns = z1 - z0 + 1
        if up:
            row = x1 * width + z0
            up = in_x(0, row, row + columns) < 0 and in_z(0, row + width, row + width + columns - 1) < 0
            x1 += up
        if down:
            row = (x0 - 1) * width + z0
            down = in_x(0, row, row + columns) < 0 and in_z(0, row, row + columns - 1) < 0
            x0 -= down
        begin, end = x0 * width, x1 * width + 1
        if right:
            right = 0 not in along_z[begin + z1 : end + z1 : width]
            right = right and 0 not in along_x[begin + z1 + 1 : end - width + z1 + 1 : width]
            z1 += right
        if left:
            left = 0 not in along_z[begin + z0 - 1 : end + z0 - 1 : width]
            left = left and 0 not in along_x[begin + z0 - 1 : end - width + z0 - 1 : width]
            z0 -= left
    for row in range(x0 - 1, x1 + 1):
        along_x[row * width + z0 : row * width + z1 + 1] = bytes(z1 - z0 + 1)
    for row in range(x0, x1 + 1):
        along_z[row * width + z0 - 1 : row * width + z1 + 1] = bytes(z1 - z0 + 2)
    return x0, x1, z0, z1


def portals(ground: Ground, rectangles: Rectangles) -> Portals:
    """Return all borders of two pieces that can be stepped across."""
    owner, places = rectangles.owner, ground.places
    rows, ends, axes = [], [], []
    for direction in (0, 1):
        target = ground.links[direction]
        here = np.flatnonzero((target >= 0) & (owner >= 0) & (owner[target] >= 0) & (owner != owner[target]))
        there = target[here]
        line, place = ((places.x, places.z), (places.z, places.x))[direction]
        order = np.lexsort((place[here], line[here], owner[there], owner[here]))
        here, there = here[order], there[order]
        key = np.stack([owner[here], owner[there], line[here], place[here] - np.arange(len(here))])
        starts = np.flatnonzero(np.append(True, (key[:, 1:] != key[:, :-1]).any(axis=0))[: len(here)])
        stops = np.append(starts[1:], len(here))[: len(starts)] - 1
        middle = (ground.points(here) + ground.points(there)) / 2
        rows.append(np.stack([owner[here[starts]], owner[there[starts]]], axis=1))
        ends.append(np.stack([middle[starts], middle[stops]], axis=1))
        axes.append(np.full(len(starts), direction))
    return Portals(np.concatenate(rows), np.concatenate(ends), np.concatenate(axes))
