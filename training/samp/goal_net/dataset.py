"""Labelled objects for GoalNet: real and procedural pieces, scaled along three axes, with goals by geometry.

An object is stored as the occupancy of the voxel grid, its size, and the goals in the grid's frame. Mirror images and
quarter turns are permutations of the grid's cells.
"""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import chain

import numpy as np

from ....samp_addon.scene.seats import seats
from ....samp_addon.scene.voxels import InteractionGrid
from ... import furniture

SMALLEST_BED = 1.2
"""Least size, metres, of objects that are searched for places to lie."""
REAL_CATEGORIES = frozenset(
    {"armchair", "chair", "stool", "bench", "sofa", "office_chair", "bed", "lounger", "table", "desk"}
)


@dataclass(frozen=True)
class LabelledObject:
    """An object with its goals for one action.

    occupancy: (8, 8, 8). size: (3,) of the grid, metres. goals: (N, 6) in the grid's frame. weights: (N,) with sum 1.
    action: index into models.goal_net.ACTIONS. name, category: of the piece.
    """

    occupancy: np.ndarray
    size: np.ndarray
    goals: np.ndarray
    weights: np.ndarray
    action: int
    name: str
    category: str

    def features(self) -> np.ndarray:
        """Return GoalNet's input (2048,), equal to InteractionGrid.object_features."""
        centres = (np.indices((8, 8, 8)).transpose(1, 2, 3, 0) + 0.5) / 8 - 0.5
        return np.concatenate([centres * self.size, self.occupancy[..., None]], axis=-1).ravel()

    def mirrored(self) -> LabelledObject:
        """Return the mirrored object, with left and right exchanged."""
        sign = np.array([-1.0, 1, 1, -1, 1, 1])
        return self._with(self.occupancy[::-1], self.size, self.goals * sign)

    def turned(self, quarters: int) -> LabelledObject:
        """Return the object with its grid turned: the yaw decreases by ``quarters`` quarter turns."""
        out = self
        for _ in range(quarters % 4):
            swapped = out.occupancy.transpose(2, 1, 0)[:, :, ::-1]
            goals = out.goals[:, [2, 1, 0, 5, 4, 3]] * [1, 1, -1, 1, 1, -1]
            out = out._with(swapped, out.size[[2, 1, 0]], goals)
        return out

    def _with(self, occupancy: np.ndarray, size: np.ndarray, goals: np.ndarray) -> LabelledObject:
        return LabelledObject(occupancy, size, goals, self.weights, self.action, self.name, self.category)


def label(piece: furniture.Piece, triangles: np.ndarray) -> list[LabelledObject]:
    """Return the labelled objects, at most one for each action, of a piece's triangles (F, 3, 3), metres."""
    support = seats.support_map(triangles)
    chairs = seats.seats_on_map(support, "sit", seats.MANY_SEATS)
    grid = InteractionGrid.build(triangles, seats.front_of_map(support, chairs))
    # Includes loungers, with the trunk on the raised back.
    beds = seats.seats_or_ring(support, "lie")[1] if grid.size.max() > SMALLEST_BED else []
    into = _grid_axes(grid.yaw)
    out = []
    for index, found in enumerate((chairs, beds)):
        if not found:
            continue
        place = np.array([seat.goal.position - grid.centre for seat in found]) @ into
        facing = np.array([seat.goal.direction for seat in found]) @ into
        score = np.array([seat.score for seat in found])
        out.append(
            LabelledObject(
                grid.occupancy.reshape(8, 8, 8).astype(np.float32),
                grid.size,
                np.hstack([place, facing]),
                score / score.sum(),
                index,
                piece.name,
                piece.category,
            )
        )
    return out


def scaled(triangles: np.ndarray, rng: np.random.Generator, most: float = 0.18) -> np.ndarray:
    """Return the triangles scaled by random factors of 1 +- ``most`` along each of three axes (section 4.3)."""
    return triangles * rng.uniform(1 - most, 1 + most, 3)


def training_objects(seed: int, copies: int, procedural: int, workers: int = 1) -> list[LabelledObject]:
    """Return each real training piece ``copies`` times, randomly scaled, and ``procedural`` pieces of each category.

    The result depends only on the seed, not on the number of worker processes.
    """
    real = [(piece, copies) for piece in real_pieces(held_out=False)]
    made = [(category, procedural) for category in furniture.CATEGORIES]
    jobs = [(seed, number, *job) for number, job in enumerate([*real, *made])]
    if workers == 1:
        return list(chain.from_iterable(map(_job, jobs)))
    with ProcessPoolExecutor(workers) as pool:
        return list(chain.from_iterable(pool.map(_job, jobs)))


def _job(job: tuple[int, int, furniture.Piece | str, int]) -> list[LabelledObject]:
    seed, number, source, copies = job
    rng = np.random.default_rng([seed, number])
    objects: list[LabelledObject] = []
    for _ in range(copies):
        if isinstance(source, str):
            piece = furniture.generate(source, rng)
            objects += label(piece, scaled(piece.triangles, rng, 0.08))
        else:
            objects += label(source, scaled(source.triangles, rng))
    return objects


def held_out_objects(seed: int, copies: int) -> list[LabelledObject]:
    """Return the held-out real pieces, unscaled and randomly scaled ``copies - 1`` times."""
    rng = np.random.default_rng(seed)
    objects: list[LabelledObject] = []
    for piece in real_pieces(held_out=True):
        for copy in range(copies):
            objects += label(piece, scaled(piece.triangles, rng) if copy else piece.triangles)
    return objects


def real_pieces(held_out: bool) -> list[furniture.Piece]:
    """Return one side of the split, of REAL_CATEGORIES.

    Where the library is missing, the held-out side consists of the shipped pieces and some procedural ones; for the
    training side, raise FileNotFoundError.
    """
    if held_out and furniture.missing():
        found = [
            *furniture.load(furniture.available(), held_out=True),
            *furniture.unseen(furniture.CATEGORIES),
        ]
    else:
        found = furniture.load(held_out=held_out)
    return [piece for piece in found if piece.category in REAL_CATEGORIES]


def _grid_axes(yaw: float) -> np.ndarray:
    """Return the matrix (3, 3) by which row vectors of the world are multiplied to get the grid's axes."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
