"""A furnished room: its triangles with classes, objects and paints, and the placements of its items."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..classes import OF_CATEGORY
from . import kinds, shell
from .floorplan import Placed, Plan
from .stock import Stock

SIDES = (3.0, 8.0)  # sides of the floor, metres
AREA = (12.0, 40.0)  # square metres
HEIGHT = (2.4, 2.9)
PANE = "pane"
SHELL_OBJECT = -1


@dataclass
class Room:
    """A furnished room in the network frame, metres, with the middle of the floor at the origin.

    triangles: (F, 3, 3). classes: (F,) see classes.CLASSES. objects: (F,) index into names, -1 for the shell.
    paints: (F,) index into paint_names. names, categories: of the N items. places: (N, 4) their x, y, z and yaw.
    """

    kind: str
    size: tuple[float, float, float]
    triangles: np.ndarray
    classes: np.ndarray
    objects: np.ndarray
    paints: np.ndarray
    paint_names: list[str]
    names: list[str]
    categories: list[str]
    places: np.ndarray

    @property
    def seats(self) -> list[int]:
        """Indices of the items on which people may sit or lie."""
        return [k for k, c in enumerate(self.categories) if OF_CATEGORY.get(c) in ("chair", "sofa", "bed")]

    def save(self, path: Path) -> None:
        """Write the room to one compressed file."""
        np.savez_compressed(
            path, kind=self.kind, size=np.array(self.size), triangles=self.triangles.astype(np.float32),
            classes=self.classes, objects=self.objects, paints=self.paints, paint_names=np.array(self.paint_names),
            names=np.array(self.names), categories=np.array(self.categories), places=self.places,
        )  # fmt: skip

    @classmethod
    def load(cls, path: Path) -> Room:
        """Read a room written by save."""
        with np.load(path) as d:
            return cls(
                str(d["kind"]), tuple(float(v) for v in d["size"]), d["triangles"].astype(np.float64), d["classes"],
                d["objects"], d["paints"], [str(n) for n in d["paint_names"]], [str(n) for n in d["names"]],
                [str(n) for n in d["categories"]], d["places"],
            )  # fmt: skip


def furnish(kind: str, stock: Stock, rng: np.random.Generator) -> Room:
    """Return a new room of a kind (one of kinds.KINDS), deterministic in the stock and the rng's state."""
    while True:
        width, depth = rng.uniform(*SIDES, 2)
        if AREA[0] <= width * depth <= AREA[1] and max(width, depth) < 2.2 * min(width, depth):
            break
    size = (float(width), float(depth), float(rng.uniform(*HEIGHT)))
    plan = Plan(shell.build(size, (1, 3), rng), rng)
    kinds.KINDS[kind](plan, stock)
    kinds.finish(plan, kind)
    return _assembled(kind, plan)


def _assembled(kind: str, plan: Plan) -> Room:
    rows: list[tuple[np.ndarray, int, int, str]] = [
        (part.triangles, part.number, SHELL_OBJECT, paint) for paint, part in plan.shell.parts
    ]
    for number, placed in enumerate(plan.placed):
        for k, part in enumerate(placed.item.parts):
            rows.append((_moved(part.triangles, placed), part.number, number, f"{placed.item.name}/{k}"))
    names = sorted({paint for *_, paint in rows})
    index = {name: k for k, name in enumerate(names)}
    spread = lambda values, kind: np.concatenate(
        [np.full(len(triangles), value, kind) for (triangles, *_), value in zip(rows, values, strict=True)]
    )
    return Room(
        kind, plan.shell.size, np.concatenate([triangles for triangles, *_ in rows]),
        spread([r[1] for r in rows], np.uint8), spread([r[2] for r in rows], np.int16),
        spread([index[r[3]] for r in rows], np.int16), names, [p.item.name for p in plan.placed],
        [p.item.category for p in plan.placed],
        np.array([[p.x, p.y, p.z, p.yaw] for p in plan.placed]).reshape(-1, 4),
    )  # fmt: skip


def _moved(triangles: np.ndarray, placed: Placed) -> np.ndarray:
    out = shell.placed(triangles, np.array([placed.x, placed.z]), placed.yaw)
    return out + [0.0, placed.y, 0.0]
