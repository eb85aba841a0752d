"""Furniture for fitting: training pieces with their seats, beds, distance fields and voxel grids."""

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
"""Compression of the pieces of a category under a body, metres; all others are hard."""
PLACES = 8
GOOD_ENOUGH = 0.7  # least score of a place to lie, relative to the best one's
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
        """Compression under a body, metres."""
        return SOFT.get(self.category, 0.0)

    @cached_property
    def surface(self) -> np.ndarray:
        """Samples (N, 3) of the surface, metres."""
        return geometry.sample_surface(self.triangles, SAMPLES, seed=0)[0]

    @cached_property
    def field(self) -> PieceField:
        """The piece's distance field."""
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
        """Places to lie whose score is near the best one's, which excludes those with the head at the foot end."""
        found = seats.seats_on_map(self._map, "lie", PLACES)
        return [seat.goal for seat in found if seat.score > GOOD_ENOUGH * found[0].score]

    def seat_surface(self, goal: Goal) -> SeatSurface:
        """Return the surface of a seat, cached."""
        key = (*np.round(goal.position, 4), *np.round(goal.direction, 4))
        kept = self.__dict__.setdefault("_surfaces", {})
        if key not in kept:
            kept[key] = SeatSurface.of(self.surface, goal)
        return kept[key]


def collect(folder: Path | None, seed: int, share: float = 1.0) -> list[FittingPiece]:
    """Return procedural pieces and the real training pieces of a folder, the latter randomly scaled.

    share: of the number of procedural pieces, for quick trials.
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
    """Return the voxel grids of all pieces: centres (P, 512, 3), metres, and occupancy (P, 512)."""
    made = [InteractionGrid.build(piece.triangles, yaw=0.0) for piece in pieces]
    return {
        "centres": np.array([grid.centres for grid in made], np.float32),
        "occupancy": np.array([grid.occupancy for grid in made], np.float32),
    }
