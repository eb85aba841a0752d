"""Furniture to fit bodies to: training pieces with their seats, beds, distances and voxel grids."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from ....samp_addon.motion import Goal
from ....samp_addon.scene import geometry
from ....samp_addon.scene.seats import seats
from ....samp_addon.scene.voxels import InteractionGrid
from ... import furniture
from .depth import PieceField
from .surfaces import SeatSurface

PROCEDURAL = {"chair": 18, "armchair": 14, "stool": 7, "bar_stool": 10, "bench": 5, "sofa": 10, "l_sofa": 3,
              "office_chair": 9, "pouf": 3, "bed": 7}  # fmt: skip
SOFT = {"armchair": 0.03, "sofa": 0.03, "l_sofa": 0.03, "bed": 0.03, "pouf": 0.02, "office_chair": 0.01}
"""Metres that the pieces of a category give under a body; all others are hard."""
PLACES = 8
GOOD_ENOUGH = 0.7  # of the best place's score, for lying
SAMPLES = 60_000
PLACELESS = ("table", "desk")


@dataclass(eq=False)
class FittingPiece:
    """One piece in its own frame. index: its number in the training set's grids."""

    index: int
    category: str
    name: str
    triangles: np.ndarray

    @property
    def give(self) -> float:
        """Metres that it gives under a body."""
        return SOFT.get(self.category, 0.0)

    @cached_property
    def surface(self) -> np.ndarray:
        """Samples (N, 3) of its surface."""
        return geometry.sample_surface(self.triangles, SAMPLES, seed=0)[0]

    @cached_property
    def field(self) -> PieceField:
        """Its distances."""
        return PieceField.of(self.triangles, self.give)

    @cached_property
    def _map(self) -> seats.SupportMap:
        return seats.support_map(self.triangles, floor_height=0.0)

    @cached_property
    def seats(self) -> list[Goal]:
        """Places to sit."""
        return [seat.goal for seat in seats.seats_on_map(self._map, "sit", PLACES)]

    @cached_property
    def beds(self) -> list[Goal]:
        """Places to lie that are nearly as good as the best: heads belong on the pillows' side."""
        found = seats.seats_on_map(self._map, "lie", PLACES)
        return [seat.goal for seat in found if seat.score > GOOD_ENOUGH * found[0].score]

    def seat_surface(self, goal: Goal) -> SeatSurface:
        """The surface about a seat; kept."""
        key = (*np.round(goal.position, 4), *np.round(goal.direction, 4))
        kept = self.__dict__.setdefault("_surfaces", {})
        if key not in kept:
            kept[key] = SeatSurface.of(self.surface, goal)
        return kept[key]


def collect(folder: Path | None, seed: int, share: float = 1.0) -> list[FittingPiece]:
    """Procedural pieces, and the real ones of a folder that may be trained on, each a little scaled.

    share: of the procedural numbers, for quick trials.
    """
    rng = np.random.default_rng(seed)
    named = [
        (name, f"{name}_{k}", furniture.generate(name, rng).triangles)
        for name, count in PROCEDURAL.items()
        for k in range(max(1, round(share * count)))
    ]
    if folder is not None and folder.exists():
        for piece in furniture.load(folder, held_out=False):
            if any(word in piece.category for word in PLACELESS):
                continue
            named.append((piece.category, piece.name, piece.triangles * rng.uniform(0.93, 1.1, 3)))
    return [FittingPiece(k, *some) for k, some in enumerate(named)]


def grids(pieces: list[FittingPiece]) -> dict[str, np.ndarray]:
    """The voxel grids of all pieces: centres (P, 512, 3) and occupancy (P, 512)."""
    made = [InteractionGrid.build(piece.triangles, yaw=0.0) for piece in pieces]
    return {
        "centres": np.array([grid.centres for grid in made], np.float32),
        "occupancy": np.array([grid.occupancy for grid in made], np.float32),
    }
