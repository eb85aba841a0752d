"""Paths around the furniture: A* over the navmesh, string pulling, and clearance at corners.

SAMP, section 3.3 and appendix E. Network frame, metres.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...errors import PathError
from ...motion import Goal
from . import corridor, funnel, smoothing
from .navmesh import NavMesh

TOLERANCE = 1.0
"""Metres, horizontally, by which start and goal may be off walkable ground."""
COMFORT = 0.10
"""Metres of clearance beyond the character's radius at corners, where there is space."""
STAND_OFF = 0.6
"""Metres in front of the pelvis goal at which the character stops and turns."""
REACH, REACH_LYING = 1.3, 2.0
"""Metres from the goal within which the character can still begin to sit, or to lie down on a wide bed."""
BEHIND = 0.5
"""Metres added to the distance of a place straight behind a seat, relative to one in front."""
CLIMBED = 0.4
"""Metres added to the distance of a place on rough ground."""
WALL = 1.1
"""Metres over the floor below which solid cells are walls to a character on its way to a seat. What hangs higher with
nothing below it, such as an upper bunk or a canopy, is not."""
OVER_PELVIS = {"sit": 0.08, "lie": 0.2}
"""Metres over the pelvis from which on solid cells are walls: backrests and table tops are, seats and armrests not."""
GAP = 0.12
"""Metres of free floor behind an obstacle on the way to a seat from which on the way leads across it: over a coffee
table. A seat itself has none."""
LOWEST = (0.05, 0.15)
"""Metres over the floor, for low and for other seats, from which on solid cells on the way to them are obstacles."""
UNDER_PELVIS = 0.22
"""Metres under the pelvis down to which solid cells are those of the seat."""
LEAST_WALL = 0.3
"""Least height of the range that is searched for walls, for high seats."""


@dataclass(frozen=True)
class Path:
    """waypoints: (N, 3) on the ground, metres, network frame, from the start to the goal; N is at least 1."""

    waypoints: np.ndarray

    @property
    def length(self) -> float:
        """Metres along the way-points."""
        return float(np.linalg.norm(np.diff(self.waypoints, axis=0), axis=1).sum())


def plan(
    mesh: NavMesh,
    start: np.ndarray,
    goal: np.ndarray,
    tolerance: float = TOLERANCE,
    comfort: float = COMFORT,
) -> Path:
    """Find a path from start (3,) to goal (3,), metres.

    Ends off the mesh are moved to the nearest walkable place, the goal to the nearest reachable one. Corners get
    ``comfort`` metres more clearance than needed, where there is space. Raises PathError if an end is farther than
    ``tolerance`` from a walkable place, or if there is no path.
    """
    begin = _on_mesh(mesh, start, tolerance, "start")
    island = int(mesh.island_of(mesh.ground.at(begin)))
    anywhere = _on_mesh(mesh, goal, tolerance, "goal")
    reachable = _on_mesh(mesh, goal, np.inf, "goal", island)
    if np.linalg.norm(reachable - anywhere) > tolerance:
        raise PathError(
            f"No way leads from the start to the goal for a character {2 * mesh.agent.radius:.2f} m wide; "
            "move the furniture apart, or make the character's radius smaller."
        )
    return _find_path(mesh, begin, reachable, comfort)


def plan_to_goal(
    mesh: NavMesh,
    start: np.ndarray,
    goal: Goal,
    stand_off: float = STAND_OFF,
    reach: float | None = None,
    tolerance: float = TOLERANCE,
    comfort: float = COMFORT,
) -> Path:
    """Find a path from start (3,) to a place from which the character can sit or lie down at the goal.

    That place is ``stand_off`` metres in front of the goal, or the nearest walkable one within ``reach`` metres of the
    goal (default 1.3, or 2 to lie down) that no wall separates from it. tolerance, comfort: see `plan`. Raises
    PathError if there is no such place or no path.
    """
    return _find_path(mesh, *ends(mesh, start, goal, stand_off, reach, tolerance), comfort)


def ends(
    mesh: NavMesh,
    start: np.ndarray,
    goal: Goal,
    stand_off: float = STAND_OFF,
    reach: float | None = None,
    tolerance: float = TOLERANCE,
) -> tuple[np.ndarray, np.ndarray]:
    """Return where the path of `plan_to_goal` begins and ends, (3,) each; raises the same errors without planning."""
    begin = _on_mesh(mesh, start, tolerance, "start")
    island = int(mesh.island_of(mesh.ground.at(begin)))
    if reach is None:
        reach = REACH_LYING if goal.action == "lie" else REACH
    approach = _approaches(mesh, goal, stand_off, reach)
    if len(approach) == 0:
        raise PathError(
            f"There is no free floor within {reach:.1f} m of the {goal.action} goal; make room around it."
        )
    reachable = approach[mesh.island_of(approach) == island]
    if len(reachable) == 0:
        raise PathError(
            f"No way leads from the start to the {goal.action} goal for a character "
            f"{2 * mesh.agent.radius:.2f} m wide; move the furniture apart, or choose another start."
        )
    return begin, mesh.ground.points(reachable[0])


def _on_mesh(
    mesh: NavMesh, position: np.ndarray, tolerance: float, end: str, island: int | None = None
) -> np.ndarray:
    """Project a position (3,) onto the ground, or move it to the nearest walkable place.

    Raises PathError beyond the tolerance. end: "start" or "goal", for the message.
    """
    position = np.asarray(position, dtype=np.float64)
    number = mesh.nearest(position, island)
    place = mesh.ground.points(number)
    across, cell = np.abs(place - position)[[0, 2]], mesh.ground.grid.cell
    if (across <= cell / 2).all():
        return np.array([position[0], place[1], position[2]])
    away = float(np.hypot(*across))
    if away > tolerance:
        raise PathError(
            f"The {end} is {away:.1f} m from the nearest walkable place; move it onto free floor."
        )
    return place


def _approaches(mesh: NavMesh, goal: Goal, stand_off: float, reach: float) -> np.ndarray:
    """Return the walkable places around the goal that no wall separates from it, best first."""
    numbers, points = mesh.walkable, mesh.points
    offset = points - goal.position
    away = np.hypot(offset[:, 0], offset[:, 2])
    # The floor in front of a seat or bed: below the pelvis, on the same storey.
    near = np.flatnonzero((away <= reach) & (offset[:, 1] < 0.1) & (offset[:, 1] > -mesh.agent.height))
    numbers, points, offset, away = numbers[near], points[near], offset[near], away[near]
    facing = (offset[:, [0, 2]] @ goal.direction[[0, 2]]) / np.maximum(away, 1e-6)
    if goal.action == "lie":
        # Beds are entered from the sides.
        cost = away + BEHIND * np.abs(facing)
    else:
        ideal = goal.position + stand_off * goal.direction
        cost = np.hypot(*(points - ideal).T[[0, 2]]) + BEHIND * (1 - facing) / 2
    cost += CLIMBED * mesh.ground.rough[numbers]
    visible = ~_walled_off(mesh, points, goal)
    order = np.argsort(cost, kind="stable")
    return numbers[order[visible[order]]]


def _walled_off(mesh: NavMesh, points: np.ndarray, goal: Goal) -> np.ndarray:
    """Flag the points (N, 3) that are separated from the goal by something solid as high as a backrest."""
    if len(points) == 0:
        return np.zeros(0, dtype=bool)
    grid, key, span = mesh.ground.grid, mesh.solid_keys, mesh.solid_span
    share = np.linspace(0, 1, int(np.ceil(2 * REACH_LYING / grid.cell)))[:, None]
    x, z = (
        ((points[:, k] * (1 - share) + goal.position[k] * share - grid.corner[k]) / grid.cell).astype(int)
        for k in (0, 2)
    )
    column = (np.clip(x, 0, grid.shape[0] - 1) * grid.shape[1] + np.clip(z, 0, grid.shape[1] - 1)) * span

    def solid_between(low: np.ndarray, high: np.ndarray) -> np.ndarray:
        a, b = (np.clip((h - grid.corner[1]) / grid.level, 0, span - 1).astype(int) for h in (low, high))
        return np.searchsorted(key, column + b) > np.searchsorted(key, column + a)

    low = np.full(len(points), goal.position[1] + OVER_PELVIS.get(goal.action, 0.0))
    high = np.maximum(points[:, 1] + WALL, low + LEAST_WALL)
    rise = np.clip(goal.position[1] - points[:, 1] - UNDER_PELVIS, *LOWEST)
    met = solid_between(points[:, 1] + rise, high)
    step = np.hypot(*(points - goal.position).T[[0, 2]]) / len(share)
    behind = (np.maximum.accumulate(met, axis=0) & ~met).sum(axis=0) * step
    return solid_between(low, high).any(axis=0) | (behind > GAP)


def _find_path(mesh: NavMesh, start: np.ndarray, goal: np.ndarray, comfort: float) -> Path:
    """Find a path between two points (3,) on the ground."""
    if (
        smoothing.visible(mesh, start, goal)
        and smoothing.line_cost(mesh, start, goal) < np.linalg.norm(goal - start) + 1e-6
    ):
        return Path(smoothing.add_height_waypoints(mesh, np.stack([start, goal])))
    owner = mesh.pieces.owner
    first, last = int(owner[mesh.ground.at(start)]), int(owner[mesh.ground.at(goal)])
    portals = corridor.search(mesh, start, goal, first, last)
    if portals is None:
        raise PathError("No way leads from the start to the goal; move the furniture apart.")
    corners = _pull_string(mesh, portals, first, start, goal)
    corners = smoothing.shorten(mesh, corners)
    corners = smoothing.widen_corners(mesh, corners, comfort)
    return Path(smoothing.add_height_waypoints(mesh, corners))


def _pull_string(
    mesh: NavMesh, way: list[int], first: int, start: np.ndarray, goal: np.ndarray
) -> np.ndarray:
    """Return corners (K, 3) of the shortest polyline through a sequence of portals."""
    pieces, ends = mesh.portals.pieces[way], mesh.portals.ends[way]
    forward, polygon = np.zeros((len(way), 2)), first
    for k, axis in enumerate(mesh.portals.axis[way]):
        ahead = pieces[k, 0] == polygon
        forward[k, axis] = 1.0 if ahead else -1.0
        polygon = pieces[k, 1] if ahead else pieces[k, 0]
    left, right = funnel.left_and_right(ends[:, :, [0, 2]], forward)
    flat = funnel.pull(start[[0, 2]], goal[[0, 2]], left, right)
    line, corner = smoothing.project_onto_ground(mesh, flat, start[1])
    return line[corner]
