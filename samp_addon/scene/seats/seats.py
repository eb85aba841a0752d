"""Goals by geometry: where on a mesh a body can sit or lie, and which way it faces (the labels of section 4.3).

Any mesh will do; only gravity is assumed, neither a front nor a category. Network frame, metres.

A goal's position is the pelvis joint's. Its direction is the root's heading: the horizontal perpendicular to the hip
line. For a body that sits it points where the knees point. For a body that lies on its back the left hip is still
left of it, so the heading points from the head to the feet.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ... import frames
from ...motion import Goal
from .. import geometry
from . import front, postures
from .support import SupportMap

DIRECTIONS = 24
MANY_SEATS = 64
"""Goals enough for all sides of a large object to have their say about its front."""
MAX_PLACES = 800
MIN_SCORE_SHARE = {"sit": 0.35, "lie": 0.5}
"""A goal's least share of the best goal's score on the same object."""
MIN_SCORE = 0.15
BACKED_SCORE = 0.6
"""Scores of seats above this have a back to lean on, so that they tell where an object's front is."""


@dataclass(frozen=True)
class Seat:
    """A goal with its score, 0 to 1, and its height over the floor, metres, of the surface under the pelvis."""

    goal: Goal
    score: float
    surface: float


def find_goals(
    triangles: np.ndarray,
    action: str,
    floor_height: float | None = None,
    obstacles: np.ndarray | None = None,
    limit: int = 16,
) -> list[Goal]:
    """Goals for an action, "sit" or "lie", best first; an empty list where the object carries nobody.

    triangles: (F, 3, 3) of the object. floor_height: metres; left out, the object's lowest point. obstacles:
    (G, 3, 3) other things that the body must not hit. Raises SampError for an object without a surface.
    """
    return [seat.goal for seat in find_seats(triangles, action, floor_height, obstacles, limit)]


def find_seats(
    triangles: np.ndarray,
    action: str,
    floor_height: float | None = None,
    obstacles: np.ndarray | None = None,
    limit: int = 16,
) -> list[Seat]:
    """As find_goals, with scores."""
    return seats_on_map(support_map(triangles, floor_height, obstacles), action, limit)


def support_map(
    triangles: np.ndarray, floor_height: float | None = None, obstacles: np.ndarray | None = None
) -> SupportMap:
    """The object's support map along its own axes; build it once to ask several questions."""
    geometry.require_surface(triangles, "The object")
    return SupportMap.build(triangles, front.dominant_axis(triangles), floor_height, obstacles)


def seats_on_map(grid: SupportMap, action: str, limit: int = 16) -> list[Seat]:
    """The seats of a map, best first."""
    places = _candidates(grid, action)
    if not len(places):
        return []
    height = postures.surface_height(grid, places)
    yaws = np.arange(DIRECTIONS) * 2 * np.pi / DIRECTIONS
    many = np.repeat(places, DIRECTIONS, axis=0), np.tile(yaws, len(places)), np.repeat(height, DIRECTIONS)
    score = _score(grid, action, *many)
    chosen = _suppress(many[0], many[1], score, action, limit)
    if not len(chosen):
        return []
    places, yaws, height, score = _refine(grid, action, many[0][chosen], many[1][chosen])
    if action == "sit":
        score = np.where(_above_a_seat(places, height, score), 0, score)
    # Refined, neighbours may have come together.
    apart = _suppress(places, yaws, score, action, limit, 0.85)
    worth = max(MIN_SCORE, MIN_SCORE_SHARE[action] * score.max())
    return [_seat(grid, action, places[i], yaws[i], height[i], score[i]) for i in apart if score[i] >= worth]


def snap_goal(
    triangles: np.ndarray, goal: Goal, reach: float = 0.15, floor_height: float | None = None
) -> Goal | None:
    """The goal put onto the real surface: kept in place where it works, moved by up to ``reach`` metres and 30
    degrees where it does not, or None where nothing near carries the body."""
    return snap_to_map(support_map(triangles, floor_height), goal, reach)


def snap_to_map(
    grid: SupportMap, goal: Goal, reach: float = 0.15, least: float = MIN_SCORE, enough: float = 0.3
) -> Goal | None:
    """snap_goal on a map that is built already.

    least: score under which a place is refused. enough: score above which nothing is gained by moving; a high one
    draws the goal to better places near by, a low one leaves it where it was asked for.
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
    # Heights are the same for all turns of a place.
    single, back = np.unique(places, axis=0, return_inverse=True)
    height = postures.surface_height(grid, single)[back.ravel()]
    score = _score(grid, goal.action, places, yaws, height)
    away = (offset**2).sum(-1) / reach**2 + (turn / np.radians(30)) ** 2
    value = np.where(score >= least, np.minimum(score, enough) - 0.3 * away, -np.inf)
    best = int(np.argmax(value))
    if not np.isfinite(value[best]):
        return None
    return _seat(grid, goal.action, places[best], yaws[best], height[best], score[best]).goal


def infer_front_yaw(triangles: np.ndarray) -> float:
    """Yaw in radians of the object's front: the side to which people sit; network frame, (-pi, pi].

    Along the object's own axis, the quarter turn to which its sit goals point; without a clear one, away from the
    side that rises (a headboard); without that, square to the long side.
    """
    return front_of_map(support_map(triangles))


def front_of_map(grid: SupportMap, seats: list[Seat] | None = None) -> float:
    """infer_front_yaw on a map that is built already; ``seats`` to sit on, where they are known."""
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
        # Steady under rounding: of two equal ways the one nearer to +Z.
        pull = facing[int(size[0] < 0.97 * size[1])]
        pull = pull if pull[2] > -1e-6 else -pull
    yaw = quarters[int(np.argmax(facing @ pull))]
    return float(frames.wrap_angle(yaw))


def _away_from_raised_side(grid: SupportMap) -> np.ndarray:
    """World vector (3,) from what stands higher than the rest to the middle; zero where nothing clearly does."""
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
    """Places (N, 2) on the object that carry at a fitting height, evenly spread."""
    low, high = postures.SIT_HEIGHTS if action == "sit" else postures.LIE_HEIGHTS
    fits = (grid.heights >= low) & (grid.heights <= high)
    stride = max(2, int(np.ceil(np.sqrt(fits.sum() / MAX_PLACES))))
    at = np.argwhere(fits[::stride, ::stride]) * stride
    return (at + 0.5) * grid.cell + grid.corner


def _score(
    grid: SupportMap, action: str, places: np.ndarray, yaws: np.ndarray, height: np.ndarray
) -> np.ndarray:
    return (postures.sit_score if action == "sit" else postures.lie_score)(grid, places, yaws, height)


def _suppress(
    places: np.ndarray, yaws: np.ndarray, score: np.ndarray, action: str, limit: int, share: float = 1.0
) -> np.ndarray:
    """Indices of the best candidates, best first, none too close to a better one in both place and direction."""
    near, turn = (0.34, np.radians(50)) if action == "sit" else (0.45, np.radians(100))
    near, turn = share * near, share * turn
    left, chosen = score.copy(), []
    while len(chosen) < limit:
        best = int(np.argmax(left))
        if left[best] <= 0:
            break
        chosen.append(best)
        apart = np.hypot(*(places - places[best]).T)
        angle = np.abs(frames.wrap_angle(yaws - yaws[best]))
        # A much worse place has no claim of its own so close by: the edge of a sofa between two backed seats.
        reach = np.where(score < 0.7 * score[best], 1.4 * near, near)
        left[(apart < reach) & (angle < turn)] = 0
    return np.array(chosen, dtype=int)


def _above_a_seat(places: np.ndarray, height: np.ndarray, score: np.ndarray) -> np.ndarray:
    """Which (N,) candidates look down on a seat close by that is as good: backs and arms as wide as a seat."""
    apart = np.hypot(*(places[:, None] - places).transpose(2, 0, 1))
    drop = height[:, None] - height
    return ((apart < 0.9) & (drop > 0.1) & (drop < 0.5) & (score > 0.7 * score[:, None])).any(axis=1)


def _refine(
    grid: SupportMap, action: str, places: np.ndarray, yaws: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Each candidate moved to the best of its neighbours, in two rounds of shrinking steps."""
    height = postures.surface_height(grid, places)
    score = _score(grid, action, places, yaws, height)
    for step, turn in ((0.025, np.radians(7.5)), (0.0125, np.radians(3))):
        x, z, t = np.meshgrid(*[(-1, 0, 1)] * 3, indexing="ij")
        moves = np.stack([x.ravel() * step, z.ravel() * step], axis=-1)
        trial = (places[:, None] + moves).reshape(-1, 2)
        turned = (yaws[:, None] + t.ravel() * turn).ravel()
        level = postures.surface_height(grid, trial)
        value = _score(grid, action, trial, turned, level).reshape(len(places), -1)
        # A small price on moving keeps what is equally good in place.
        price = 0.002 * (np.abs(x) + np.abs(z) + np.abs(t)).ravel()
        best = np.argmax(value - price, axis=1) + np.arange(len(places)) * len(price)
        places, yaws, height, score = trial[best], turned[best], level[best], value.ravel()[best]
    return places, yaws, height, score


def _seat(grid: SupportMap, action: str, place: np.ndarray, yaw: float, height: float, score: float) -> Seat:
    lift = postures.SEAT_TO_PELVIS if action == "sit" else postures.BED_TO_PELVIS
    position = grid.to_world(place, np.asarray(height + lift))
    return Seat(Goal(position, frames.yaw_direction(yaw + grid.yaw), action), float(score), float(height))
