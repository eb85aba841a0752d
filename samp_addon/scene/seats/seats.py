"""Goals by geometry: where on a mesh a body can sit or lie, and which way it faces (the labels of SAMP, section 4.3).

The mesh needs neither a known front nor a category; only the direction of gravity is assumed. Network frame, metres.

The position of a goal is that of the pelvis joint. Its direction is the root's heading, the horizontal perpendicular to
the hip line. For a sitting body it points where the knees point. A body that lies on its back has its left hip on the
same side, so the heading points from the head to the feet.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ... import frames
from ...motion import Goal
from .. import geometry
from ..remembered import by_content
from . import front, postures, reclining
from .support import SupportMap
from .suppression import above_adjacent_seat, suppress

DIRECTIONS = 24
MANY_SEATS = 64
"""Enough goals for all sides of a large object to influence the estimate of its front."""
MAX_PLACES = 800
RECLINE = "recline"
"""Posture of a goal to lie with a raised back."""
MIN_SCORE_SHARE = {"sit": 0.35, "lie": 0.5, RECLINE: 0.7}
"""Least score of a goal, relative to the best goal on the same object."""
MIN_SCORE = 0.15
LOUNGER = 0.7
"""Score of lying on a raised back, relative to lying flat, from which on an object is a lounger."""
WRONG_END = -0.25
"""Evidence for the head, see postures.head_evidence, below which a goal to lie is turned the wrong way."""
PERCH, PERCH_RISE = 0.6, 0.15
"""Metres over the floor, and over the object's own seat, from which on a place is the top of a back or an armrest."""
BACKED_SCORE = 0.6
"""Least score of seats with a back, which determine the front of an object."""


@dataclass(frozen=True)
class Seat:
    """A goal, its score from 0 to 1, the height over the floor of the surface under the pelvis, metres, and whether a
    body lies there with a raised back."""

    goal: Goal
    score: float
    surface: float
    reclined: bool = False


def find_goals(
    triangles: np.ndarray,
    action: str,
    floor_height: float | None = None,
    obstacles: np.ndarray | None = None,
    limit: int = 16,
) -> list[Goal]:
    """Find goals for an action, "sit" or "lie", best first; the list is empty if the object supports none.

    triangles: (F, 3, 3) of the object. floor_height: metres; the object's lowest point if left out. obstacles:
    (G, 3, 3) of other objects that the body must not touch. Raises SampError for an object without a surface.
    """
    return [seat.goal for seat in find_seats(triangles, action, floor_height, obstacles, limit)]


def find_seats(
    triangles: np.ndarray,
    action: str,
    floor_height: float | None = None,
    obstacles: np.ndarray | None = None,
    limit: int = 16,
) -> list[Seat]:
    """Find goals with scores; see `find_goals`."""
    found = seats_or_ring(support_map(triangles, floor_height, obstacles), action, limit)[1]
    return found if obstacles is None else without_perches(found, triangles, action, floor_height)


def seats_or_ring(grid: SupportMap, action: str, limit: int = 16) -> tuple[SupportMap, list[Seat]]:
    """Find the seats on a support map or, without any, on the map with its holes filled, as of a toilet's seat.

    On a lounger, bodies lie with the trunk on its back. Return the map that was used as well.
    """
    found = seats_on_map(grid, action, limit)
    if action == "lie":
        reclined = seats_on_map(grid, RECLINE, limit)
        flat = max((seat.score for seat in found), default=0.0)
        found = reclined if reclined and reclined[0].score > LOUNGER * flat else found
    if found or action != "sit":
        return grid, found
    filled = grid.with_filled_holes(postures.SIT_HEIGHTS)
    if filled is None:
        return grid, found
    return filled, seats_on_map(filled, action, limit)


def without_perches(
    found: list[Seat], triangles: np.ndarray, action: str, floor_height: float | None = None
) -> list[Seat]:
    """Return the seats found among obstacles, or none where only high places are left of an object whose own seat is
    lower: where crates are on the sofa, nobody sits on its back."""
    if action != "sit" or not found or found[0].surface < PERCH:
        return found
    alone = seats_or_ring(support_map(triangles, floor_height), action, limit=4)[1]
    lower = [seat for seat in alone if seat.surface < found[0].surface - PERCH_RISE]
    return [] if lower and lower[0].score > found[0].score else found


def wrong_way(grid: SupportMap, goal: Goal) -> bool:
    """Return whether a goal to lie has its feet where the pillows or the headboard are."""
    yaw = float(frames.direction_yaw(goal.direction)) - grid.yaw
    return goal.action == "lie" and postures.head_evidence(grid, grid.to_grid(goal.position), yaw) < WRONG_END


def support_map(
    triangles: np.ndarray, floor_height: float | None = None, obstacles: np.ndarray | None = None
) -> SupportMap:
    """Build the support map of an object along its main axis, to be shared by several queries."""
    geometry.require_surface(triangles, "The object")
    return SupportMap.build(triangles, front.dominant_axis(triangles), floor_height, obstacles)


def seats_on_map(grid: SupportMap, action: str, limit: int = 16) -> list[Seat]:
    """Find the seats on a support map, best first."""
    places = _candidates(grid, action)
    if not len(places):
        return []
    height = postures.surface_height(grid, places)
    yaws = np.arange(DIRECTIONS) * 2 * np.pi / DIRECTIONS
    many = np.repeat(places, DIRECTIONS, axis=0), np.tile(yaws, len(places)), np.repeat(height, DIRECTIONS)
    score = score_at(grid, action, *many)
    chosen = suppress(many[0], many[1], score, action, limit)
    if not len(chosen):
        return []
    places, yaws, height, score = _refine(grid, action, many[0][chosen], many[1][chosen])
    if action == "sit":
        score = np.where(above_adjacent_seat(places, height, score), 0, score)
    # Refinement may have moved neighbours together.
    apart = suppress(places, yaws, score, action, limit, 0.85)
    worth = max(MIN_SCORE, MIN_SCORE_SHARE[action] * score.max())
    return [
        seat_at(grid, action, places[i], yaws[i], height[i], score[i]) for i in apart if score[i] >= worth
    ]


def snap_goal(
    triangles: np.ndarray, goal: Goal, reach: float = 0.15, floor_height: float | None = None
) -> Goal | None:
    """Snap a goal to the surface.

    It is kept in place if that is possible, else moved by up to ``reach`` metres and 30 degrees. Return None if no
    place in reach supports the body.
    """
    return snap_to_map(support_map(triangles, floor_height), goal, reach)


def snap_to_map(
    grid: SupportMap, goal: Goal, reach: float = 0.15, least: float = MIN_SCORE, enough: float = 0.3
) -> Goal | None:
    """Snap a goal to the surface of a support map; see `snap_goal`.

    least: places with a lower score are rejected. enough: scores above this do not justify moving the goal; a high
    value attracts it to better places nearby, a low one keeps it in place.
    """
    at = grid.to_grid(goal.position)
    yaw = float(frames.direction_yaw(goal.direction)) - grid.yaw
    step = np.arange(-reach, reach + 1e-9, 0.025)
    x, z, turn = (
        a.ravel() for a in np.meshgrid(step, step, np.radians([0, -10, 10, -20, 20, -30, 30]), indexing="ij")
    )
    near = x**2 + z**2 <= reach**2 + 1e-9
    offset, turn = np.stack([x[near], z[near]], axis=-1), turn[near]
    places, yaws = at + offset, yaw + turn
    # Heights do not depend on the yaw.
    single, back = np.unique(places, axis=0, return_inverse=True)
    height = postures.surface_height(grid, single)[back.ravel()]
    posture = goal.action
    score = score_at(grid, posture, places, yaws, height)
    if posture == "lie" and not (score >= least).any():
        posture = RECLINE
        score = score_at(grid, posture, places, yaws, height)
    away = (offset**2).sum(-1) / reach**2 + (turn / np.radians(30)) ** 2
    value = np.where(score >= least, np.minimum(score, enough) - 0.3 * away, -np.inf)
    best = int(np.argmax(value))
    if not np.isfinite(value[best]):
        return None
    return seat_at(grid, posture, places[best], yaws[best], height[best], score[best]).goal


@by_content(kept=16)
def infer_front_yaw(triangles: np.ndarray) -> float:
    """Return the yaw of an object's front, the side that seated bodies face; radians, network frame, [-pi, pi).

    Of the quarter turns along the object's main axis, it is the one to which the sit goals point; without a clear one,
    the one away from a raised side (a headboard); without that, the one perpendicular to the long side.
    """
    return front_of_map(support_map(triangles))


def front_of_map(grid: SupportMap, seats: list[Seat] | None = None) -> float:
    """Return the yaw of the front on a support map; see `infer_front_yaw`. seats: sit goals, if known already."""
    seats = seats_on_map(grid, "sit", MANY_SEATS) if seats is None else seats
    quarters = grid.yaw + np.arange(4) * np.pi / 2
    facing = frames.yaw_direction(quarters)
    pull = sum((seat.score**2 * seat.goal.direction for seat in seats), np.zeros(3))
    rise = _away_from_raised_side(grid)
    backed = bool(seats) and seats[0].score >= BACKED_SCORE
    clear = np.linalg.norm(pull) >= 0.25 * sum(seat.score**2 for seat in seats)
    if not clear or (rise.any() and not backed):
        pull = rise
    if not pull.any():
        size = grid.high - grid.low
        # Stable under rounding: of two equal directions, the one closer to +Z.
        pull = facing[int(size[0] < 0.97 * size[1])]
        pull = pull if pull[2] > -1e-6 else -pull
    yaw = quarters[int(np.argmax(facing @ pull))]
    return float(frames.wrap_angle(yaw))


def _away_from_raised_side(grid: SupportMap) -> np.ndarray:
    """Return the world vector (3,) from a raised part to the centre, or zero if no part is clearly raised."""
    filled = grid.counts[:, 1:] != grid.counts[:, :-1]
    tops = np.where(filled.any(axis=1), filled.shape[1] - filled[:, ::-1].argmax(axis=1), 0)
    cells = np.nonzero(tops)
    height = tops[cells].astype(float)
    centre = np.stack(cells, axis=-1) * grid.cell + grid.corner - (grid.low + grid.high) / 2
    high = height > 0.6 * height.max()
    if not high.any() or high.mean() > 0.6:
        return np.zeros(3)
    away = -centre[high].mean(axis=0)
    if np.abs(away).max() < 0.12 * (grid.high - grid.low).max():
        return np.zeros(3)
    return grid.to_world(away, np.zeros(())) - [0, grid.floor, 0]


def _candidates(grid: SupportMap, action: str) -> np.ndarray:
    """Return evenly spaced places (N, 2) whose supporting surface has a suitable height."""
    low, high = postures.SIT_HEIGHTS if action == "sit" else postures.LIE_HEIGHTS
    fits = (grid.heights >= low) & (grid.heights <= high)
    stride = max(2, int(np.ceil(np.sqrt(fits.sum() / MAX_PLACES))))
    at = np.argwhere(fits[::stride, ::stride]) * stride
    return (at + 0.5) * grid.cell + grid.corner


def score_at(
    grid: SupportMap, action: str, places: np.ndarray, yaws: np.ndarray, height: np.ndarray
) -> np.ndarray:
    """Return the scores (N,) of bodies at places (N, 2) with yaws (N,) on surfaces at heights (N,), see postures.py."""
    scores = {"sit": postures.sit_score, "lie": postures.lie_score, RECLINE: reclining.recline_score}
    return scores[action](grid, places, yaws, height)


def _refine(
    grid: SupportMap, action: str, places: np.ndarray, yaws: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Move each candidate to the best of its neighbours, in two rounds of decreasing steps."""
    height = postures.surface_height(grid, places)
    score = score_at(grid, action, places, yaws, height)
    for step, turn in ((0.025, np.radians(7.5)), (0.0125, np.radians(3))):
        x, z, t = np.meshgrid(*[(-1, 0, 1)] * 3, indexing="ij")
        moves = np.stack([x.ravel() * step, z.ravel() * step], axis=-1)
        trial = (places[:, None] + moves).reshape(-1, 2)
        turned = (yaws[:, None] + t.ravel() * turn).ravel()
        level = postures.surface_height(grid, trial)
        value = score_at(grid, action, trial, turned, level).reshape(len(places), -1)
        # A small penalty on moving keeps equally good candidates in place.
        price = 0.002 * (np.abs(x) + np.abs(z) + np.abs(t)).ravel()
        best = np.argmax(value - price, axis=1) + np.arange(len(places)) * len(price)
        places, yaws, height, score = trial[best], turned[best], level[best], value.ravel()[best]
    return places, yaws, height, score


def seat_at(
    grid: SupportMap, action: str, place: np.ndarray, yaw: float, height: float, score: float
) -> Seat:
    """Return the seat at a place (2,) of a support map, facing a yaw in the map's frame."""
    lift = postures.SEAT_TO_PELVIS if action == "sit" else postures.BED_TO_PELVIS
    position = grid.to_world(place, np.asarray(height + lift))
    goal = Goal(position, frames.yaw_direction(yaw + grid.yaw), "lie" if action == RECLINE else action)
    return Seat(goal, float(score), float(height), action == RECLINE)
