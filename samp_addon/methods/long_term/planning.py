"""Windows between sub-goals: the way from each to the next, and places between where a window cannot reach.

Network frame, metres.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import PathError, SampError
from ...frames import direction_yaw, ground_lengths
from ...scene.navmesh import path as paths
from ...scene.navmesh.navmesh import NavMesh
from ...vocabulary import SEATED
from . import variety, way
from .sub_goals import places
from .sub_goals.places import Place

REACH = 2.1
"""Metres of way that one window bridges: about two seconds of walking."""
CLEAR = 0.35
"""Metres in front of the place at which somebody begins to sit down that the last body between keeps."""
LEAST = 0.45
"""Metres of the shortest window that another place may make."""
OFF_FLOOR = 0.4
"""Metres by which a standing body may be off walkable floor: it may lean closer to things than a walker passes."""
STEP = 0.2
"""Metres between a way and the ground under it, at most."""
TANGENT = 0.25
"""Metres of way before and after a place between over which its facing is averaged."""


@dataclass(frozen=True)
class Leg:
    """The way to a place: stops are the places between and, last, the place itself; each with its path (N, 3)."""

    stops: tuple[Place, ...]
    paths: tuple[np.ndarray, ...]


def legs(mesh: NavMesh, stops: Sequence[Place], rng: np.random.Generator, scale: float) -> list[Leg]:
    """Return the ways between consecutive places, bowed at random. Raises SampError for one that cannot be reached.

    scale: of the noise; 0 for the shortest ways.
    """
    found = []
    for number, (start, end) in enumerate(zip(stops[:-1], stops[1:], strict=True), start=1):
        try:
            line = _line(mesh, start, end, rng, scale)
        except PathError as error:
            raise SampError(
                f"Sub-goal {number + 1} cannot be reached from sub-goal {number}: {_lower(error)}"
            ) from error
        found.append(divided(mesh, line, start, end))
    return found


def divided(mesh: NavMesh, line: np.ndarray, start: Place, end: Place) -> Leg:
    """Return a way (N, 3) on the floor with places between, evenly spaced, the outermost in front of the seats.

    The first and the last stretch of a way lead off and onto the furniture that its ends are on.
    """
    at = ground_lengths(line)
    total = at[-1]
    low = at[1] + CLEAR if start.action in SEATED else 0.0
    high = at[-2] - CLEAR if end.action in SEATED else total
    rests = [place.action in SEATED for place in (start, end)]
    if all(rests) and low > high:  # the body rises between two seats, however near
        low = high = (low + high) / 2
    # Windows onto and off furniture are for that alone: longer ones glide over its edge or squat on the way.
    if total > REACH or all(rests) or (any(rests) and high - low > LEAST):
        count = max(int(np.ceil((high - low) / REACH)), 1)
        marks = np.linspace(low, max(low, high), count + 1)
    else:
        marks = np.zeros(0)
    marks = [float(mark) for mark in marks if LEAST < mark < total - LEAST]
    between = [_between(mesh, line, at, mark) for mark in marks]
    cuts = [0.0, *marks, total]
    pieces = tuple(_part(line, at, a, b) for a, b in zip(cuts[:-1], cuts[1:], strict=True))
    return Leg((*between, end), pieces)


def _line(mesh: NavMesh, start: Place, end: Place, rng: np.random.Generator, scale: float) -> np.ndarray:
    """Return the way (N, 3) on the floor from one place to another, bowed where it does not lead onto furniture."""
    begin, last = start.floor, end.floor
    if np.linalg.norm((last - begin)[[0, 2]]) < way.NEAR:
        return np.array([begin, last])
    parts, front = [], begin
    if start.action in SEATED:
        near = last if end.action not in SEATED else _front(mesh, end, begin)
        front = _front(mesh, start, near)
        parts.append(begin[None])
    if end.action in SEATED:
        walk = paths.plan_to_goal(mesh, front, end.goal).waypoints
        parts += [variety.bowed(mesh, walk, rng, scale), last[None]]
    else:
        walk = paths.plan(mesh, front, last, OFF_FLOOR).waypoints
        parts.append(variety.bowed(mesh, walk, rng, scale))
    return np.concatenate(parts)


def _front(mesh: NavMesh, place: Place, towards: np.ndarray) -> np.ndarray:
    """Return the floor (3,) in front of a seat, on the side from which a point can be reached."""
    begin = mesh.ground.points(np.array(mesh.nearest(towards)))
    return paths.plan_to_goal(mesh, begin, place.goal).waypoints[-1]


def _between(mesh: NavMesh, line: np.ndarray, at: np.ndarray, mark: float) -> Place:
    """Return a place that is walked through, on the ground: a way is straight over a step lower than a stair."""
    floor, before, after = (_point(line, at, mark + shift) for shift in (0.0, -TANGENT, TANGENT))
    ground = float(mesh.heights_at(floor))
    floor[1] = ground if abs(ground - floor[1]) < STEP else floor[1]
    yaw = float(direction_yaw(after - before))
    return Place("walk", floor + [0.0, places.standing_height(), 0.0], yaw, floor, fixed=False)


def _point(line: np.ndarray, at: np.ndarray, mark: float) -> np.ndarray:
    return np.array([np.interp(mark, at, line[:, axis]) for axis in range(3)])


def _part(line: np.ndarray, at: np.ndarray, low: float, high: float) -> np.ndarray:
    """Return the part of a way between two distances."""
    inner = line[(at > low + 1e-6) & (at < high - 1e-6)]
    return np.concatenate([_point(line, at, low)[None], inner, _point(line, at, high)[None]])


def _lower(error: Exception) -> str:
    text = str(error)
    return text[:1].lower() + text[1:]
