"""Goals on an object, sampled by GoalNet (section 3.2) and snapped to its surface.

Network frame, metres. The direction of a goal is the heading of the root: see scene/seats/.
"""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...errors import NoPlaceError, SampError
from ...motion import Goal
from ...scene.seats import back, seats
from ...scene.seats.seats import Seat
from ...scene.seats.support import SupportMap
from ...scene.voxels import InteractionGrid
from ...vocabulary import SEATED
from .load_networks import load_goal_net

ROUNDS = 6
"""Rounds of samples; each draws a few more than the number of goals."""
GOOD = 0.7
"""Share of the best score on the object above which a sample is not moved."""
KEPT = 4
"""Objects in the cache."""
SIT_BACK = 0.75
"""Share of sits, on seats with a rest, that are moved back to it as far as the shins allow; the others stay in front.
GoalNet sits too far forward on deep seats: people were captured on stools and chairs only."""
MAX_SHIFT = 0.20
"""Metres by which a sampled goal may be moved to a place with support."""


@dataclass(frozen=True)
class GoalSamples:
    """Sampled goals.

    by_geometry: how many of the goals, at the end of the list, come from the search on the mesh, because too few of the
    network's samples were supported. rejected: how many samples were not supported.
    """

    goals: list[Goal]
    by_geometry: int = 0
    rejected: int = 0


def sample_goals(
    triangles: np.ndarray,
    action: str,
    count: int = 1,
    seed: int = 0,
    obstacles: np.ndarray | None = None,
    floor_height: float | None = None,
) -> list[Goal]:
    """Return the goals of draw_goals."""
    return draw_goals(triangles, action, count, seed, obstacles, floor_height).goals


def draw_goals(
    triangles: np.ndarray,
    action: str,
    count: int = 1,
    seed: int = 0,
    obstacles: np.ndarray | None = None,
    floor_height: float | None = None,
) -> GoalSamples:
    """Sample different goals for "sit" or "lie" on an object with GoalNet, and snap each to the surface.

    triangles: (F, 3, 3) of the object. count: number of goals. obstacles: (G, 3, 3) of everything else that the body
    must not hit. floor_height: metres; the object's lowest point if omitted. The same seed gives the same goals.
    Samples without support are drawn again; where the network finds too few, the search by geometry supplies the rest.
    Raises NoPlaceError where there is no place to sit or lie.
    """
    if action not in SEATED:
        raise SampError(
            f"Goals on an object are for 'sit' and 'lie', not for '{action}'; choose one of these."
        )
    piece = _piece(triangles, action, obstacles, floor_height)
    support, found, grid = piece.support, piece.found, piece.grid
    if not found:
        raise NoPlaceError(f"There is no place to {action} on this object; {_advice(action)}.")
    # Samples meet the criterion of the training labels: not much worse than the object's best place.
    best = found[0].score
    least, enough = seats.MIN_SCORE_SHARE[action] * best, GOOD * best
    goals: list[Goal] = []
    rejected = 0
    for sample in _network_samples(grid, action, count, seed):
        if len(goals) == count:
            break
        snapped = seats.snap_to_map(support, sample, MAX_SHIFT, least, enough)
        if snapped is not None and seats.wrong_way(piece.alone, snapped):
            snapped = None
        rejected += snapped is None
        goals += [] if snapped is None else [snapped]
    missing = count - len(goals)
    # Cycle through the best places, starting at a different one for each seed.
    right = [seat for seat in found if not seats.wrong_way(piece.alone, seat.goal)] or found
    goals += [right[(seed + k) % len(right)].goal for k in range(missing)]
    if action == "sit":
        chance = np.random.default_rng(int(seed) % 2**63)
        goals = [back.slid_back(support, g) if chance.random() < SIT_BACK else g for g in goals]
    return GoalSamples(goals, missing, rejected)


@dataclass(frozen=True)
class _Piece:
    """What all samples on an object share: its support, that without the obstacles, the seats found by geometry, and
    the grid that the network sees."""

    support: SupportMap
    alone: SupportMap
    found: list[Seat]
    grid: InteractionGrid | None


_pieces: OrderedDict[tuple, _Piece] = OrderedDict()


def _piece(
    triangles: np.ndarray, action: str, obstacles: np.ndarray | None, floor_height: float | None
) -> _Piece:
    """Return the analysed object, cached: every take of a batch needs it."""
    digest = (
        lambda a: None if a is None else hashlib.blake2b(np.ascontiguousarray(a), digest_size=16).digest()
    )
    key = digest(triangles), digest(obstacles), action, floor_height
    if key not in _pieces:
        support = seats.support_map(triangles, floor_height, obstacles)
        support, found = seats.seats_or_ring(support, action, seats.MANY_SEATS)
        if obstacles is not None:
            found = seats.without_perches(found, triangles, action, floor_height)
        # The front is that of the object alone, whatever stands around it.
        grid = InteractionGrid.build(triangles, seats.infer_front_yaw(triangles)) if found else None
        # A wall at the feet is no headboard.
        alone = seats.support_map(triangles, floor_height) if action == "lie" else support
        _pieces[key] = _Piece(support, alone, found, grid)
    _pieces.move_to_end(key)
    while len(_pieces) > KEPT:
        _pieces.popitem(last=False)
    return _pieces[key]


def _advice(action: str) -> str:
    """Return what to do where there is no place for an action."""
    if action == "lie":
        return "choose one with a flat, free surface of about 1.7 x 0.5 m below 0.85 m"
    return "choose one with a flat, free seat between 0.25 and 0.85 m and room for the legs"


def _network_samples(grid: InteractionGrid, action: str, count: int, seed: int) -> Iterator[Goal]:
    """Yield goals in the world frame, ROUNDS times a few more than the count."""
    import torch

    from ....models import goal_net

    net = load_goal_net()
    generator = torch.Generator().manual_seed(int(seed) % 2**63)
    cos, sin = np.cos(grid.yaw), np.sin(grid.yaw)
    to_world = np.array([[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]])
    features = torch.from_numpy(grid.object_features().astype(np.float32))[None]
    # Gradients are off for the network only: a caller that stops half-way must find them as they were.
    with torch.no_grad():
        condition = net.condition(features, torch.tensor([goal_net.ACTIONS.index(action)]))
    for _ in range(ROUNDS):
        # One row at a time, so that goal k of a seed does not depend on the count.
        for _ in range(count + 4):
            z = torch.randn(1, goal_net.LATENT, generator=generator)
            with torch.no_grad():
                goal = net.draw(condition, z)[0].double().numpy()
            facing = goal[3:] @ to_world * [1.0, 0.0, 1.0]
            length = np.linalg.norm(facing)
            if length > 0.2:
                yield Goal(grid.centre + goal[:3] @ to_world, facing / length, action)
