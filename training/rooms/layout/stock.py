"""The stock of rooms: seats, beds and tables of one side of the held-out split, and procedural pieces."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from ....samp_addon.evaluation.obstacles import Obstacles
from ... import furniture
from ...furniture.library import DEFAULT_FOLDER
from ..classes import OF_CATEGORY, Part

# Procedural pieces of each category in a training stock.
PROCEDURAL = {"chair": 30, "armchair": 16, "stool": 6, "bar_stool": 8, "bench": 8, "sofa": 18, "l_sofa": 8,
              "office_chair": 12, "pouf": 6, "bed": 14, "table": 36}  # fmt: skip
LOW_TABLE, SMALL = 0.58, 1.0  # largest height of a low table, and longer side of a small one, metres


@dataclass(frozen=True)
class Item:
    """An item of a room in its own frame: front +Z, on y = 0, metres."""

    name: str
    category: str
    parts: list[Part]

    @cached_property
    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest corner (3,)."""
        points = np.concatenate([part.triangles.reshape(-1, 3) for part in self.parts])
        return points.min(0), points.max(0)

    @cached_property
    def triangles(self) -> np.ndarray:
        """All triangles (F, 3, 3)."""
        return np.concatenate([part.triangles for part in self.parts])

    @cached_property
    def obstacles(self) -> Obstacles:
        """The item as obstacles, for measuring penetration."""
        return Obstacles(self.triangles)

    @property
    def size(self) -> np.ndarray:
        """Width, height and depth (3,)."""
        return self.box[1] - self.box[0]

    def top(self, x: float, z: float) -> float:
        """Return the height, metres, of the highest surface at (x, z) in the item's frame; -inf outside."""
        a, b, c = (self.triangles[:, k][:, [0, 2]] - [x, z] for k in range(3))
        cross = lambda p, q: p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
        u, v, w = cross(b, c), cross(c, a), cross(a, b)
        whole = u + v + w
        over = (np.minimum(np.minimum(u * whole, v * whole), w * whole) >= 0) & (np.abs(whole) > 1e-9)
        if not over.any():
            return -np.inf
        share = np.stack([u, v, w], -1)[over] / whole[over, None]
        return float((share * self.triangles[over][:, :, 1]).sum(-1).max())


class Stock:
    """Items by category; random choices use the caller's rng."""

    def __init__(self, items: list[Item]) -> None:
        self.of: dict[str, list[Item]] = defaultdict(list)
        for item in items:
            self.of[item.category].append(item)

    def named(self) -> dict[str, Item]:
        """Return all items by name."""
        return {item.name: item for items in self.of.values() for item in items}

    def pick(self, rng: np.random.Generator, *categories: str, most: float = np.inf) -> Item | None:
        """Return a random item, at most ``most`` metres wide and deep, of a random category; None without one."""
        fits = [[i for i in self.of[c] if max(i.size[0], i.size[2]) <= most] for c in categories]
        fits = [items for items in fits if items]
        if not fits:
            return None
        items = fits[rng.integers(len(fits))]
        return items[rng.integers(len(items))]


def build(
    folder: Path = DEFAULT_FOLDER, test: bool = False, seed: int = 0, seats: list[Item] | None = None
) -> Stock:
    """Return the stock of training rooms, real and procedural, or of test rooms, held-out real pieces only.

    seats: replacements of all items for sitting and lying; tables stay.
    """
    pieces = furniture.load(folder, held_out=test) if (Path(folder) / "manifest.csv").exists() else []
    if not test:
        rng = np.random.default_rng([seed, 77])
        pieces += [furniture.generate(name, rng) for name, count in PROCEDURAL.items() for _ in range(count)]
    items = [_item(piece) for piece in pieces if piece.category in OF_CATEGORY]
    if seats is not None:
        items = [*(i for i in items if OF_CATEGORY[_category(i)] == "table"), *seats]
    return Stock(items)


def _category(item: Item) -> str:
    return "table" if item.category.endswith("table") else item.category


def _item(piece: furniture.Piece) -> Item:
    category = piece.category
    part = Part(OF_CATEGORY[category], piece.triangles)
    item = Item(piece.name, category, [part])
    if category == "table":
        width, height, depth = item.size
        kind = "low_table" if height < LOW_TABLE else "small_table" if max(width, depth) <= SMALL else "table"
        return Item(piece.name, kind, item.parts)
    if category == "stool" and item.size[1] > 0.7:
        return Item(piece.name, "bar_stool", item.parts)
    return item
