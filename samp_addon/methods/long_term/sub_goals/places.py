"""What carries a body at a sub-goal: the floor, a seat or a bed; and why some points cannot be sub-goals.

Network frame, metres.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ....body import human
from ....errors import SampError
from ....frames import yaw_direction
from ....motion import Goal
from ....scene.distance import solids
from ....scene.navmesh.lattice import clip_to_box
from ....scene.navmesh.navmesh import NavMesh
from ....scene.seats import postures, seats
from ..surfaces import Surfaces

if TYPE_CHECKING:
    from ..figure import Figure

ABOVE, BELOW = 0.15, 0.30
"""Metres above and below a point within which its support is looked for."""
LEVEL = 0.75
"""Least vertical component of a supporting surface's normal."""
STEP = 0.12
"""Metres over the floor up to which a surface is floor: rugs and thresholds."""
BESIDE = 0.30
"""Metres from walkable floor within which a standing body is possible: closer to things than a walker goes."""
TRUNK = (0.4, 0.9, 1.3)
"""Metres over the floor at which the middle of a standing body has to be free."""
PIECE = 1.4
"""Metres around a point that are looked at as the piece of furniture."""
REACH = 0.15
"""Metres by which a seated pelvis may be moved to fit."""
TURNS = np.radians([90, -90, 180, 45, -45, 135, -135])
"""Facings that are tried beside the front of a piece of furniture."""
BED, CELL = 0.75, 0.05
"""Metres: a surface wider than the first in both directions is a bed; it is measured in steps of the second."""
BACK = 1.0
"""Metres over a seat within which its back is found."""
GOOD_LIE = 0.5
"""Least score of a place to lie; others are sat on."""


@dataclass(frozen=True)
class Place:
    """A place that a take passes.

    action: "idle", "sit" or "lie". pelvis: (3,) where the pelvis is wanted. yaw: radians. floor: (3,) on the ground
    below. fixed: whether the artist chose it; others are put between where a window cannot reach. body: that the artist
    chose, or None to draw one.
    """

    action: str
    pelvis: np.ndarray
    yaw: float
    floor: np.ndarray
    fixed: bool = True
    body: Figure | None = None

    @property
    def goal(self) -> Goal:
        """The place as a goal of the pelvis."""
        return Goal(self.pelvis, yaw_direction(self.yaw), self.action)


def find(surfaces: Surfaces, point: np.ndarray, yaw: float, name: str) -> Place:
    """Return the place of a sub-goal: a point (3,) on what carries the body, and its facing in radians.

    name: of the sub-goal, for messages. Raises SampError for a point in the air or inside something.
    """
    triangles, mesh = surfaces.triangles, surfaces.mesh
    surface = support(triangles, point)
    floor = _floor(mesh, point)
    if surface is None:
        laid = mesh.laid_ground
        if laid is None or abs(laid - point[1]) > BELOW:
            raise SampError(f"{name} is in the air; put it onto a floor, a seat or a bed.")
        surface = laid
    if surface - floor[1] < STEP:
        return standing(surfaces, np.array([point[0], floor[1], point[2]]), yaw, name)
    return _seat(triangles, np.array([point[0], surface, point[2]]), yaw, floor, name)


def facing(surfaces: Surfaces, point: np.ndarray, wanted: float, name: str) -> float:
    """Return the facing in radians of a body at a point (3,): on a floor the wanted one, on a seat out of its front, on
    a bed along it; elsewhere the first one in which a body fits. Raises SampError as `find` does."""
    surface, floor = support(surfaces.triangles, point), _floor(surfaces.mesh, point)
    yaws, is_bed = [wanted], False
    if surface is not None and surface - floor[1] >= STEP:
        piece, place = _piece(surfaces.triangles, point, floor), np.array([point[0], surface, point[2]])
        front = seats.infer_front_yaw(piece)
        yaws = [front, wanted, *(front + turn for turn in TURNS)]
        is_bed = min(_width(piece, place, front + turn) for turn in (0.0, np.pi / 2)) > BED
    first, problem = None, None
    for yaw in yaws:
        try:
            found = find(surfaces, point, yaw, name)
        except SampError as error:
            problem = problem or error
            continue
        if found.action == "lie" or not is_bed:
            return yaw
        first = yaw if first is None else first
    if first is None:
        raise problem
    return first


def _width(triangles: np.ndarray, point: np.ndarray, yaw: float) -> float:
    """Return how far the surface at a point (3,) goes on in a direction and the opposite one, metres, to 5 cm."""
    total = 0.0
    for way in (yaw_direction(yaw), -yaw_direction(yaw)):
        for step in range(1, round(BED / CELL) + 1):
            height = support(triangles, point + step * CELL * way, BACK)  # the seat may go on under its back
            if height is None or abs(height - point[1]) > STEP:
                break
            total += CELL
    return total


def standing(surfaces: Surfaces, floor: np.ndarray, yaw: float, name: str) -> Place:
    """Return the place of a body that stands on the floor (3,). Raises SampError where there is no room for it."""
    nearest = surfaces.mesh.ground.points(np.array(surfaces.mesh.nearest(floor)))
    middle = floor + np.outer(TRUNK, [0.0, 1.0, 0.0])
    if np.linalg.norm((nearest - floor)[[0, 2]]) > BESIDE or surfaces.is_solid(middle):
        raise SampError(f"{name} is inside a wall or too close to something; move it onto free floor.")
    return Place("idle", floor + [0.0, standing_height(), 0.0], yaw, floor)


def standing_height() -> float:
    """Return the height of the pelvis joint of the default human that stands with slightly bent knees."""
    return -human.load().floor - 0.015


def seated(goal: Goal, yaw: float, mesh: NavMesh) -> Place:
    """Return the place of a goal on a seat or a bed."""
    return Place(goal.action, np.asarray(goal.position), yaw, _floor(mesh, goal.position))


def support(triangles: np.ndarray, point: np.ndarray, above: float = ABOVE) -> float | None:
    """Return the height of the highest level surface at a point (3,), or None without one close to it.

    above: metres over the point up to which it is looked for.
    """
    low, high = point - [1e-3, BELOW, 1e-3], point + [1e-3, above, 1e-3]
    near = solids.overlapping_box(triangles, low, high)
    if not len(near):
        return None
    normal = np.cross(near[:, 1] - near[:, 0], near[:, 2] - near[:, 0])
    size = np.linalg.norm(normal, axis=-1)
    near, normal = near[size > 1e-12], normal[size > 1e-12]
    flat = np.abs(normal[:, 1]) > LEVEL * np.linalg.norm(normal, axis=-1)
    near, normal = near[flat], normal[flat]
    inside = np.ones(len(near), bool)
    for k in range(3):
        a, b = near[:, k], near[:, (k + 1) % 3]
        side = (b[:, 0] - a[:, 0]) * (point[2] - a[:, 2]) - (b[:, 2] - a[:, 2]) * (point[0] - a[:, 0])
        inside &= side * -np.sign(normal[:, 1]) >= -1e-9
    near, normal = near[inside], normal[inside]
    drop = (normal[:, [0, 2]] * (point[[0, 2]] - near[:, 0][:, [0, 2]])).sum(-1) / normal[:, 1]
    heights = near[:, 0, 1] - drop
    heights = heights[(heights >= point[1] - BELOW) & (heights <= point[1] + above)]
    return float(heights.max()) if len(heights) else None


def _seat(triangles: np.ndarray, point: np.ndarray, yaw: float, floor: np.ndarray, name: str) -> Place:
    """Return the place to lie, where there is a good one in this direction, else to sit."""
    grid = seats.support_map(_piece(triangles, point, floor), floor[1])
    direction = yaw_direction(yaw)
    for action, lift, least in (
        ("lie", postures.BED_TO_PELVIS, GOOD_LIE),
        ("sit", postures.SEAT_TO_PELVIS, seats.MIN_SCORE),
    ):
        wanted = Goal(point + [0.0, lift, 0.0], direction, action)
        found = seats.snap_to_map(grid, wanted, REACH, least)
        if found is not None and not seats.wrong_way(grid, found):
            turned = float(np.arctan2(found.direction[0], found.direction[2]))
            return Place(action, found.position, turned, floor)
    raise SampError(
        f"{name} is on something that nobody can sit or lie on; move it onto a seat, a bed or the floor."
    )


def _piece(triangles: np.ndarray, point: np.ndarray, floor: np.ndarray) -> np.ndarray:
    """Return the triangles (G, 3, 3) over the floor (3,) around a point (3,)."""
    low, high = point - PIECE, point + PIECE
    low[1], high[1] = floor[1] + 0.02, floor[1] + 1.6
    return clip_to_box(solids.overlapping_box(triangles, low, high), low, high)


def _floor(mesh: NavMesh, point: np.ndarray) -> np.ndarray:
    """Return the ground (3,) below a point: that at its own place, else the nearest walkable one's height."""
    below = point - [0.0, 0.5, 0.0]
    number = int(mesh.ground.at(below))
    if number < 0 or mesh.pieces.owner[number] < 0:
        number = mesh.nearest(below)
    return np.array([point[0], mesh.ground.points(np.array(number))[1], point[2]])
