"""Procedural furniture: seeded, varied pieces of every category that people sit or lie on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from . import flat, office_chair, seating, shapes
from .piece import Piece

_BUILDERS = {
    "armchair": seating.armchair,
    "chair": seating.chair,
    "stool": seating.stool,
    "bar_stool": seating.bar_stool,
    "bench": seating.bench,
    "sofa": seating.sofa,
    "l_sofa": seating.l_sofa,
    "office_chair": office_chair.office_chair,
    "pouf": seating.pouf,
    "bed": flat.bed,
    "table": flat.table,
}
CATEGORIES = tuple(_BUILDERS)

EVALUATION_SEED = 20_000_003
"""Seed of the procedural pieces used in the evaluation; training uses other seeds."""


def generate(category: str, rng: np.random.Generator) -> Piece:
    """Return a new piece of a category, centred over the origin, front +Z, on y = 0; deterministic in the rng's state.

    Raise KeyError for a category that is not in CATEGORIES.
    """
    build = _BUILDERS[category]
    mark = int(rng.integers(2**31))
    soup = shapes.join(build(np.random.default_rng(mark)))
    low, high = soup.min(axis=(0, 1)), soup.max(axis=(0, 1))
    soup = soup - [(low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2]
    return Piece(category, soup, f"{category}_{mark:010d}")


def unseen(categories: Sequence[str], each: int = 1) -> list[Piece]:
    """Return procedural pieces that are not used in training; the same ones at every call."""
    rng = np.random.default_rng(EVALUATION_SEED)
    return [generate(category, rng) for category in categories if category in _BUILDERS for _ in range(each)]
