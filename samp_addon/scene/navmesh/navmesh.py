"""The walkable surface of a scene as convex polygons (SAMP paper, section 3.3). Network frame."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ... import frames
from ...errors import PathError
from .. import geometry
from . import ground, heightfield, islands, lattice, rectangles
from .ground import Ground
from .heightfield import Grid
from .rectangles import Portals, Rectangles

CELL = 0.05
MAX_COLUMNS = 500_000
"""Columns of the grid; 35 x 35 m at 5 cm. Larger scenes are cut, or get larger cells."""
REACH = 0.6
"""Metres up to which the distance to obstacles is known."""
DETOUR = 6.0
"""Metres around start and goal that the part of a large scene holds at least."""
SMALLEST_ROOM = 2.5
"""Metres. A scene that is smaller is a piece of furniture, whose top is no floor."""
FLOOR_SHARE, FLOOR_UNEVEN, FLOOR_THICKNESS = 0.2, 0.1, 0.35
"""A scene has a floor if this share of its outline can be stood on, within so many metres of the lowest such
place, and that place is no higher than this over the lowest point of all."""
GROUND_MARGIN = 2.0
"""Metres by which a ground laid under a scene without a floor reaches beyond it."""
PELVIS, OTHER_STOREY = 1.2, 100.0
"""Metres: how high over the floor ``near`` may be, and how far away what lies higher or lower counts as."""
POCKET = 1.0
"""Metres that the room may begin farther off than the gap behind the sofa, when a free place is looked for."""
UPHILL = 2.0
"""How much a metre of height counts beside a metre across, when the nearest place is looked for."""


@dataclass(frozen=True)
class Agent:
    """The character as a cylinder: radius, height and highest step in metres, steepest slope in radians."""

    radius: float = 0.22
    height: float = 1.7
    step: float = 0.25
    slope: float = math.radians(40.0)


@dataclass(frozen=True)
class NavMesh:
    """agent: whom it is for. ground: all standing places. pieces: the walkable convex polygons over them.

    portals: where these touch. solid: all solid cells. laid_ground: height in metres
    of a ground that was laid, or None.
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
        """Corners (P, 4, 3) of the polygons in metres, counter-clockwise seen from above."""
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
        """For each polygon (P,) the number of the connected part it belongs to."""
        return ground.connected(len(self.pieces), self.portals.pieces)

    @cached_property
    def walkable(self) -> np.ndarray:
        """Numbers (W,) of the places that belong to a polygon."""
        return np.flatnonzero(self.pieces.owner >= 0)

    @cached_property
    def points(self) -> np.ndarray:
        """Middles (W, 3) of the walkable places, metres."""
        return self.ground.points(self.walkable)

    @property
    def area(self) -> float:
        """Walkable area seen from above, square metres."""
        return len(self.walkable) * self.ground.grid.cell**2

    def island_of(self, places: np.ndarray) -> np.ndarray:
        """Connected part (...) of walkable places (...)."""
        return self.islands[self.pieces.owner[places]]

    def nearest(self, position: np.ndarray, island: int | None = None) -> int:
        """Number of the walkable place closest to a position (3,), height counting double."""
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
    """The navmesh of triangles (F, 3, 3) for a character.

    cell: side of the grid's cells, metres. floor_height: lays a level ground there (metres); left out, one is
    laid at the scene's lowest point if hardly anything there can be walked on. cover: points (N, 3), metres,
    such as start and goal; a laid ground reaches to them, and too large a scene is cut to their surroundings.
    Raises SampError for a scene without faces, PathError where nothing is walkable.
    """
    agent = agent or Agent()
    triangles = np.asarray(triangles, dtype=np.float64)
    cover = np.zeros((0, 3)) if cover is None else np.asarray(cover, dtype=np.float64).reshape(-1, 3)
    box, laid = _box(triangles, cover, cell), floor_height
    if box is not None:
        triangles = lattice.clip_to_box(triangles, *box)
    if laid is None:
        low, high = geometry.bounds(triangles)
        grid, solid = _solid(triangles, low, high, box, cell, agent)
        places = heightfield.standing_places(solid, grid, agent.height)
        laid = None if _has_floor(places, solid, grid) else float(low[1])
    if laid is not None:
        margin = _with_margin(triangles, cover, laid)
        if floor_height is None and box is None and _columns(*margin, grid.cell) <= MAX_COLUMNS:
            # What is solid is known already.
            wide = grid.widened(*margin)
            grid, solid = wide, solid.moved(grid, wide)
        else:
            grid, solid = _solid(triangles, *margin, box, cell, agent)
        places = heightfield.standing_places(heightfield.with_ground(solid, grid, laid), grid, agent.height)
    joined = ground.build(
        grid, places, agent.step, agent.height, agent.slope, agent.radius, max(REACH, agent.radius)
    )
    walkable = islands.prune(joined, joined.clearance >= agent.radius, agent.step)
    if not walkable.any():
        raise PathError("Nothing in the scene can be walked on; add a floor, or make the character smaller.")
    pieces = rectangles.cover(joined, walkable)
    return NavMesh(agent, joined, pieces, rectangles.portals(joined, pieces), solid, laid)


def free_place(
    navmesh: NavMesh,
    near: np.ndarray,
    distance: tuple[float, float],
    rng: np.random.Generator,
    island: int | None = None,
) -> tuple[np.ndarray, float]:
    """A place to stand, position (3,) metres and yaw in radians, at a distance (least, most) from ``near``.

    It lies on the given connected part, or the main one around ``near``, on the same storey, off the
    stairs, where there is room around it. The yaw is within a quarter turn of facing ``near``. With no
    place in range, the one closest to it is taken.
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
    # Where all is crowded, the most open third still leaves a choice.
    room = navmesh.ground.clearance[numbers[inside]]
    roomy = inside[room >= min(navmesh.agent.radius + 0.15, np.quantile(room, 0.67))]
    position = points[rng.choice(roomy)]
    towards = float(frames.direction_yaw(np.asarray(near) - position))
    return position, towards + rng.uniform(-math.pi / 2, math.pi / 2)


def _main_part(parts: np.ndarray, away: np.ndarray) -> int:
    """The largest of the parts (W,) that come about as near as the nearest; not the gap behind the sofa."""
    beside = np.unique(parts[away <= away.min() + POCKET])
    return int(beside[np.bincount(parts)[beside].argmax()])


def _box(triangles: np.ndarray, cover: np.ndarray, cell: float) -> np.ndarray | None:
    """Corners (2, 3) of the part of too large a scene that matters for ``cover``; None if all fits."""
    if len(triangles) == 0 or len(cover) == 0:
        return None
    if _columns(*geometry.bounds(triangles), cell) <= MAX_COLUMNS:
        return None
    half = np.maximum(np.ptp(cover, axis=0) / 2 + DETOUR, math.sqrt(MAX_COLUMNS) * cell / 2)
    middle = (cover.min(axis=0) + cover.max(axis=0)) / 2
    return np.stack([middle - half, middle + half])


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
    """The grid from low to high (3,), inside of the box, and its solid cells; too many cells grow larger."""
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


def _with_margin(triangles: np.ndarray, cover: np.ndarray, floor: float) -> tuple[np.ndarray, np.ndarray]:
    """Corners of a box around the scene and the points of ``cover``, with room to walk around both."""
    points = np.concatenate(
        [geometry.bounds(triangles) if len(triangles) or not len(cover) else cover, cover]
    )
    margin = np.array([GROUND_MARGIN, 0.0, GROUND_MARGIN])
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    return np.minimum(low, [np.inf, floor, np.inf]), np.maximum(high, [-np.inf, floor, -np.inf])
