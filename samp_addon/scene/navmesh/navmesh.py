"""The walkable surface of a scene as convex polygons (SAMP, section 3.3). Network frame."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ... import frames
from ...errors import PathError
from .. import geometry
from . import ground, heightfield, islands, lattice, rectangles
from .ground import Ground
from .heightfield import Grid
from .rectangles import Portals, Rectangles

CELL = 0.05
MAX_COLUMNS = 500_000
"""Columns of the grid, 35 x 35 m at 5 cm. Larger scenes are cropped, or get larger cells."""
REACH = 0.6
"""Metres up to which the clearance is measured."""
DETOUR = 6.0
"""Metres around start and goal that are kept at least when a large scene is cropped."""
SMALLEST_ROOM = 2.5
"""Metres. A smaller scene is a single piece of furniture, whose top is not a floor."""
FLOOR_SHARE, FLOOR_UNEVEN, FLOOR_THICKNESS = 0.2, 0.1, 0.35
"""A scene has a floor if more than this share of its columns has standing places within so many metres of the lowest,
and if the lowest is at most so many metres over the scene's lowest point."""
GROUND_MARGIN = 2.0
"""Metres by which the ground that is added to a scene without a floor extends beyond it."""
PELVIS, OTHER_STOREY = 1.2, 100.0
"""Metres: largest height difference to ``near`` on the same storey, and the distance added for other storeys."""
POCKET = 1.0
"""Metres by which the main part of a room may be farther away than the nearest part (the gap behind a sofa)."""
UPHILL = 2.0
"""Weight of vertical relative to horizontal distance in the search for the nearest place."""


@dataclass(frozen=True)
class Agent:
    """The character as a cylinder: radius, height and highest step in metres, steepest slope in radians."""

    radius: float = 0.22
    height: float = 1.7
    step: float = 0.25
    slope: float = math.radians(40.0)


@dataclass(frozen=True)
class NavMesh:
    """The walkable surface for one agent.

    ground: all standing places. pieces: the walkable convex polygons over them. portals: where polygons touch.
    solid: all solid cells. laid_ground: height of an added ground, metres, or None.
    """

    agent: Agent
    ground: Ground
    pieces: Rectangles
    portals: Portals
    solid: heightfield.Solid
    laid_ground: float | None = None

    def __len__(self) -> int:
        return len(self.pieces)

    @cached_property
    def polygons(self) -> np.ndarray:
        """Corners (P, 4, 3) of the polygons, metres, counter-clockwise seen from above."""
        first, last = self.pieces.first, self.pieces.last
        cell, corner = self.ground.grid.cell, self.ground.grid.corner
        low, high = corner[[0, 2]] + first * cell, corner[[0, 2]] + (last + 1) * cell
        corners = np.empty((len(first), 4, 3))
        for k, (right, far) in enumerate(((0, 0), (0, 1), (1, 1), (1, 0))):
            x = last[:, 0] if right else first[:, 0]
            z = last[:, 1] if far else first[:, 1]
            number = self.ground.index[self.pieces.layer, x, z]
            corners[:, k, 0] = high[:, 0] if right else low[:, 0]
            corners[:, k, 1] = self.ground.places.height[number]
            corners[:, k, 2] = high[:, 1] if far else low[:, 1]
        return corners

    @cached_property
    def islands(self) -> np.ndarray:
        """Index of the connected part of each polygon (P,)."""
        return ground.connected(len(self.pieces), self.portals.pieces)

    @cached_property
    def walkable(self) -> np.ndarray:
        """Indices (W,) of the places that belong to a polygon."""
        return np.flatnonzero(self.pieces.owner >= 0)

    @cached_property
    def points(self) -> np.ndarray:
        """Centres (W, 3) of the walkable places, metres."""
        return self.ground.points(self.walkable)

    @cached_property
    def solid_keys(self) -> np.ndarray:
        """A number for each solid cell (S,), in order: its column times `solid_span`, plus its level."""
        return self.solid.column * self.solid_span + self.solid.level

    @cached_property
    def solid_span(self) -> int:
        """Levels of a column, and one more."""
        return int(self.solid.level.max(initial=0)) + 2

    @property
    def area(self) -> float:
        """Walkable area in the ground plane, square metres."""
        return len(self.walkable) * self.ground.grid.cell**2

    def heights_at(self, points: np.ndarray) -> np.ndarray:
        """Return the heights (N,) of the ground that is nearest in height to points (N, 3), NaN where there is none."""
        places = self.ground.at(points)
        return np.where(places >= 0, self.ground.places.height[places], np.nan)

    def nearest_places(self, points: np.ndarray, near: np.ndarray, within: float) -> np.ndarray:
        """Return points (N, 3) moved horizontally to the nearest walkable place where they are not over one.

        near: points (M, 3) of a path; places farther from it than ``within`` metres are beyond what bounds the path.
        Points stay where they are if there is no place.
        """
        flat = self.points[:, [0, 2]]
        chosen = cKDTree(near[:, [0, 2]]).query(flat, distance_upper_bound=within)[0] <= within
        if not chosen.any():
            return points
        places = self.ground.at(points)
        here = (places >= 0) & (self.pieces.owner[places] >= 0)
        here &= cKDTree(near[:, [0, 2]]).query(points[:, [0, 2]])[0] <= within
        _, nearest = cKDTree(flat[chosen]).query(points[:, [0, 2]])
        moved = np.stack([flat[chosen][nearest, 0], points[:, 1], flat[chosen][nearest, 1]], axis=-1)
        return np.where(here[:, None], points, moved)

    def island_of(self, places: np.ndarray) -> np.ndarray:
        """Return the connected part (...) of walkable places (...)."""
        return self.islands[self.pieces.owner[places]]

    def nearest(self, position: np.ndarray, island: int | None = None) -> int:
        """Return the index of the walkable place closest to a position (3,); height counts double.

        island: restricts the search to one connected part. Raises PathError if there is no place.
        """
        numbers, points = self.walkable, self.points
        if island is not None:
            chosen = self.island_of(numbers) == island
            numbers, points = numbers[chosen], points[chosen]
        if len(numbers) == 0:
            raise PathError(
                "There is no walkable place for the character; add a floor, or make the character smaller."
            )
        away = np.hypot(*(points - position).T[[0, 2]]) + UPHILL * np.abs(points[:, 1] - position[1])
        return int(numbers[away.argmin()])


def build(
    triangles: np.ndarray,
    agent: Agent | None = None,
    cell: float = CELL,
    floor_height: float | None = None,
    cover: np.ndarray | None = None,
) -> NavMesh:
    """Build the navmesh of triangles (F, 3, 3) for a character.

    cell: side of the grid's cells, metres. floor_height: metres, where a level ground is added; if left out, one is
    added at the scene's lowest point if the scene has no floor. cover: points (N, 3), metres, such as start and goal:
    an added ground extends to them, and too large a scene is cropped around them. Raises SampError for a scene without
    faces, PathError if nothing is walkable.
    """
    agent = agent or Agent()
    triangles = np.asarray(triangles, dtype=np.float64)
    cover = np.zeros((0, 3)) if cover is None else np.asarray(cover, dtype=np.float64).reshape(-1, 3)
    box, ground_height = _box(triangles, cover, cell), floor_height
    if box is not None:
        triangles = lattice.clip_to_box(triangles, *box)
    corners = cover if len(cover) and not len(triangles) else geometry.bounds(triangles)
    if ground_height is None:
        low, high = corners if len(triangles) else geometry.bounds(triangles)
        grid, solid = _solid(triangles, low, high, box, cell, agent)
        places = heightfield.standing_places(solid, grid, agent.height)
        ground_height = None if _has_floor(places, solid, grid) else float(low[1])
    if ground_height is not None:
        margin = _with_margin(np.concatenate([corners, cover]), ground_height)
        if floor_height is None and box is None and _columns(*margin, grid.cell) <= MAX_COLUMNS:
            # The solid cells are known already.
            wide = grid.widened(*margin)
            grid, solid = wide, solid.moved(grid, wide)
        else:
            grid, solid = _solid(triangles, *margin, box, cell, agent)
        places = heightfield.standing_places(
            heightfield.with_ground(solid, grid, ground_height), grid, agent.height
        )
    joined = ground.build(
        grid, places, agent.step, agent.height, agent.slope, agent.radius, max(REACH, agent.radius)
    )
    walkable = islands.prune(joined, joined.clearance >= agent.radius, agent.step)
    if not walkable.any():
        raise PathError("Nothing in the scene can be walked on; add a floor, or make the character smaller.")
    pieces = rectangles.cover(joined, walkable)
    return NavMesh(agent, joined, pieces, rectangles.portals(joined, pieces), solid, ground_height)


def free_place(
    navmesh: NavMesh,
    near: np.ndarray,
    distance: tuple[float, float],
    rng: np.random.Generator,
    island: int | None = None,
) -> tuple[np.ndarray, float]:
    """Choose a random place to stand: position (3,), metres, and yaw, radians.

    distance: (minimum, maximum) from ``near``, metres; if no place is in range, the closest to it is taken. The place
    is on the connected part ``island``, or the main one around ``near``, on the same storey, not on rough ground, and
    with room around it. The yaw is within a quarter turn of facing ``near``.
    """
    near = np.asarray(near, dtype=np.float64)
    numbers, points = navmesh.walkable, navmesh.points
    away = np.hypot(*(points - near).T[[0, 2]])
    away += np.where(np.abs(points[:, 1] - near[1]) > PELVIS, OTHER_STOREY, 0.0)
    parts = navmesh.island_of(numbers)
    chosen = np.flatnonzero(parts == (_main_part(parts, away) if island is None else island))
    excess = np.maximum(distance[0] - away, 0) + np.maximum(away - distance[1], 0)
    inside = chosen[excess[chosen] <= max(excess[chosen].min(), 1e-9)]
    even = inside[~navmesh.ground.rough[numbers[inside]]]
    inside = even if len(even) else inside
    # In crowded rooms, choose among the most open third.
    room = navmesh.ground.clearance[numbers[inside]]
    roomy = inside[room >= min(navmesh.agent.radius + 0.15, np.quantile(room, 0.67))]
    position = points[rng.choice(roomy)]
    towards = float(frames.direction_yaw(np.asarray(near) - position))
    return position, towards + rng.uniform(-math.pi / 2, math.pi / 2)


def _main_part(parts: np.ndarray, away: np.ndarray) -> int:
    """Return the largest of the parts (W,) about as near as the nearest one: the room, not the gap behind the sofa."""
    near = np.unique(parts[away <= away.min() + POCKET])
    return int(near[np.bincount(parts)[near].argmax()])


def _box(triangles: np.ndarray, cover: np.ndarray, cell: float) -> np.ndarray | None:
    """Return corners (2, 3) of the box to which a large scene is cropped around ``cover``, or None if all fits."""
    if len(triangles) == 0 or len(cover) == 0 or fits(triangles, cell):
        return None
    half = np.maximum(np.ptp(cover, axis=0) / 2 + DETOUR, math.sqrt(MAX_COLUMNS) * cell / 2)
    middle = (cover.min(axis=0) + cover.max(axis=0)) / 2
    return np.stack([middle - half, middle + half])


def fits(triangles: np.ndarray, cell: float = CELL) -> bool:
    """Return whether a scene (F, 3, 3) is small enough for one grid, and so is not cropped."""
    return _columns(*geometry.bounds(triangles), cell) <= MAX_COLUMNS


def _columns(low: np.ndarray, high: np.ndarray, cell: float) -> float:
    return float((high - low)[0] * (high - low)[2] / cell**2)


def _solid(
    triangles: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    box: np.ndarray | None,
    cell: float,
    agent: Agent,
) -> tuple[Grid, heightfield.Solid]:
    """Return the grid from low to high (3,), cropped to the box, and its solid cells; cells grow beyond MAX_COLUMNS."""
    if box is not None:
        low, high = np.maximum(low, box[0]), np.minimum(high, box[1])
    cell *= math.sqrt(max(_columns(low, high, cell) / MAX_COLUMNS, 1.0))
    grid = Grid.over(low, high, cell)
    return grid, heightfield.solid_cells(triangles, grid, agent.slope)


def _has_floor(places: heightfield.Places, solid: heightfield.Solid, grid: Grid) -> bool:
    if len(places) == 0 or max(grid.shape) * grid.cell < SMALLEST_ROOM:
        return False
    lowest = places.height.min()
    low_enough = lowest - solid.height.min() <= FLOOR_THICKNESS
    share = (places.height < lowest + FLOOR_UNEVEN).sum() / (grid.shape[0] * grid.shape[1])
    return bool(low_enough and share > FLOOR_SHARE)


def _with_margin(points: np.ndarray, floor: float) -> tuple[np.ndarray, np.ndarray]:
    """Return corners of a box around the points (N, 3) of a scene, with a margin to walk around it."""
    margin = np.array([GROUND_MARGIN, 0.0, GROUND_MARGIN])
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    return np.minimum(low, [np.inf, floor, np.inf]), np.maximum(high, [-np.inf, floor, -np.inf])
