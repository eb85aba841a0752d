"""The thirteen classes of a room's surfaces, and meshes labelled with them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

CLASSES = (
    "floor", "wall", "ceiling", "door", "window", "table", "chair", "sofa", "bed", "cupboard", "shelf", "board",
    "clutter",
)  # fmt: skip
CLASS = {name: k for k, name in enumerate(CLASSES)}
PERSON = len(CLASSES)  # in pictures only
SEAT_CLASSES = ("chair", "sofa", "bed")
OF_CATEGORY = {
    "armchair": "sofa", "sofa": "sofa", "l_sofa": "sofa", "chair": "chair", "stool": "chair", "bar_stool": "chair",
    "bench": "chair", "office_chair": "chair", "pouf": "chair", "bed": "bed", "bunk_bed": "bed", "crib": "bed",
    "lounger": "bed", "table": "table", "desk": "table",
}  # fmt: skip
COLOURS = np.array(
    [[196, 176, 148], [225, 222, 214], [250, 250, 250], [139, 94, 60], [135, 190, 230], [214, 140, 60],
     [220, 80, 80], [120, 90, 190], [230, 120, 190], [110, 150, 70], [70, 170, 150], [60, 90, 170],
     [240, 210, 60], [30, 30, 30]], np.uint8)  # fmt: skip
"""Colours of the classes and of people on contact sheets."""


@dataclass(frozen=True)
class Part:
    """Triangles (F, 3, 3) of one class and one paint, metres."""

    name: str
    triangles: np.ndarray

    @property
    def number(self) -> int:
        """Index of the class."""
        return CLASS[self.name]
