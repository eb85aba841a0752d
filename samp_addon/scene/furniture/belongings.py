"""What belongs to a piece of furniture: the cushions, pillows and duvets on it, the frame that carries it, and the
headboard or back that stands at it.

Imported furniture is often several objects without a parent. Network frame, metres.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from ... import frames
from .. import geometry
from ..geometry import SceneGeometry
from ..seats.front import dominant_axis

WIDEST = 3.5
"""Width of the largest frame or covering."""
THICKEST = 0.32
"""Height of the thickest thing that is sat or lain on together with what it rests on, such as a mattress."""
LEAST_AREA = 0.09
"""Square metres of the smallest cushion; smaller things on a seat are in the way."""
LEAST_WIDTH = 0.22
LARGEST_RATIO = 20.0
"""Footprint of a frame relative to what it carries; a larger one is a floor or a stage."""
LOWEST_FRAME = 0.12
"""Height over its own foot at which a frame carries; lower ones are rugs."""
GAP, SUNK = 0.05, 0.12
"""Distance from a surface within which a thing rests on it, and the depth that it may be pressed in."""
LEAST_BOARD, HIGHEST_BOARD, THICKEST_BOARD = 0.12, 0.95, 0.25
"""Height of a headboard over the mattress at least and at most, and its thickness."""
WIDEST_BOARD = 2.0
"""Width of a headboard relative to the bed's; a wider one is a wall."""
OVER = 0.6
"""Least share of a footprint that is over the other one."""


def belongings(
    scene: SceneGeometry, parts: Collection[str], foreign: Collection[str] = ()
) -> tuple[str, ...]:
    """Return the names of the objects that belong to the object of these parts, without the parts.

    foreign: names of what is never furniture: characters.
    """
    boxes = _Boxes(scene)
    inside = {boxes.number[name] for name in parts if name in boxes.number}
    barred = {boxes.number[name] for name in foreign if name in boxes.number} | inside
    if not inside:
        return ()
    found: set[int] = set()
    for number in boxes.near(inside):
        if number not in barred and boxes.carries(number, inside):
            found.add(number)
            break
    whole = inside | found
    added = True
    while added:
        added = [n for n in boxes.near(whole) if n not in whole | barred and boxes.rests(n, whole)]
        whole |= set(added)
    whole |= {n for n in boxes.near(whole) if n not in whole | barred and boxes.backs(n, whole)}
    return tuple(scene.names[number] for number in sorted(whole - inside))


class _Boxes:
    """The bounding boxes of a scene's objects."""

    def __init__(self, scene: SceneGeometry) -> None:
        self.scene = scene
        self.number = {name: number for number, name in enumerate(scene.names)}
        self.low, self.high = scene.boxes

    def near(self, numbers: Collection[int]) -> list[int]:
        """Return the objects whose boxes touch that of some objects."""
        low, high = self._box(numbers)
        close = (self.low <= high + GAP).all(axis=1) & (self.high >= low - GAP).all(axis=1)
        return [int(n) for n in np.flatnonzero(close) if n not in numbers]

    def rests(self, number: int, numbers: Collection[int]) -> bool:
        """Return whether an object lies on some others and is soft furnishing by its size."""
        low, high = self.low[number], self.high[number]
        size = high - low
        if size[1] > THICKEST or size[[0, 2]].max() > WIDEST or size[[0, 2]].min() < LEAST_WIDTH:
            return False
        return size[0] * size[2] >= LEAST_AREA and self._lies_on(low, high, numbers)

    def carries(self, number: int, numbers: Collection[int]) -> bool:
        """Return whether an object is the frame under some others."""
        low, high = self._box(numbers)
        size, frame = high - low, self.high[number] - self.low[number]
        if size[1] > THICKEST or frame[[0, 2]].max() > WIDEST or low[1] < self.low[number, 1] + LOWEST_FRAME:
            return False
        if frame[0] * frame[2] > LARGEST_RATIO * max(size[0] * size[2], 1e-6):
            return False
        return self._lies_on(low, high, [number])

    def backs(self, number: int, numbers: Collection[int]) -> bool:
        """Return whether an object is a board that stands upright at one side of some others, as wide as that side."""
        whole = self.scene.triangles[np.isin(self.scene.object_ids, list(numbers))]
        board = self.scene.triangles[self.scene.object_ids == number]
        if geometry.areas(whole).sum() < geometry.MINIMUM_AREA:
            return False
        axes = frames.yawed_axes(dominant_axis(whole))
        low, high = geometry.extent(whole @ axes)
        least, most = geometry.extent(board @ axes)
        rise = most[1] - high[1]
        if not LEAST_BOARD < rise < HIGHEST_BOARD:
            return False
        for across, along in ((0, 2), (2, 0)):
            wide = high[across] - low[across]
            shared = min(most[across], high[across]) - max(least[across], low[across])
            outside = max(least[along] - high[along], low[along] - most[along])
            if (
                most[along] - least[along] < THICKEST_BOARD
                and shared > OVER * wide
                and most[across] - least[across] < WIDEST_BOARD * wide
                and -SUNK < outside < GAP
            ):
                return True
        return False

    def _box(self, numbers: Collection[int]) -> tuple[np.ndarray, np.ndarray]:
        rows = list(numbers)
        return self.low[rows].min(axis=0), self.high[rows].max(axis=0)

    def _lies_on(self, low: np.ndarray, high: np.ndarray, numbers: Collection[int]) -> bool:
        """Return whether a box lies on the surface of some objects, and mostly over them."""
        under_low, under_high = self._box(numbers)
        flat = [0, 2]
        shared = np.minimum(high, under_high)[flat] - np.maximum(low, under_low)[flat]
        if (shared <= 0).any() or shared.prod() < OVER * (high - low)[flat].prod():
            return False
        ids = np.isin(self.scene.object_ids, list(numbers))
        triangles = self.scene.triangles[ids]
        if geometry.areas(triangles).sum() < geometry.MINIMUM_AREA:
            return False
        points = geometry.spread_over_surface(triangles, 6000)[0]
        over = ((points >= low) & (points <= high))[:, flat].all(axis=1)
        rise = points[over, 1] - low[1]
        return bool(((rise > -GAP) & (rise < SUNK)).sum() >= 8)
