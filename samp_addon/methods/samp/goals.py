"""Goals on an object by GoalNet (section 3.2), each put onto the real surface.

Network frame, metres. A goal's direction is the root's heading: see scene/seats.py.
"""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...errors import SampError
from ...motion import Goal
from ...scene.seats import seats
from ...scene.seats.seats import Seat
from ...scene.seats.support import SupportMap
from ...scene.voxels import InteractionGrid
from .load_networks import load_goal_net

ROUNDS = 6
"""How often the network is asked again, for as many goals as are still missing and then some."""
GOOD = 0.7
"""Share of the best score on the object from which on a sample stays exactly where it is."""
KEPT = 4
"""Objects whose places are kept."""
MOST_SHIFT = 0.20
"""Metres by which a sampled goal may be moved to where the surface carries."""


@dataclass(frozen=True)
class GoalSamples:
    """goals: as many as were asked for. by_geometry: how many of them, at the end of the list, come from the
    search on the mesh because too few of the network's were supported. rejected: samples that were not."""

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
    """Different goals for "sit" or "lie" on an object: the goals of draw_goals."""
    return draw_goals(triangles, action, count, seed, obstacles, floor_height).goals


def draw_goals(
    triangles: np.ndarray,
    action: str,
    count: int = 1,
    seed: int = 0,
    obstacles: np.ndarray | None = None,
    floor_height: float | None = None,
) -> GoalSamples:
    """GoalNet's samples, each moved onto the surface; those that nothing carries are drawn again.

    triangles: (F, 3, 3) of the object. obstacles: (G, 3, 3) of what else the body must not hit. floor_height: where
    the character stands, metres; left out, the object's lowest point. The same seed gives the same goals. Where the
    network finds too few, the search by geometry fills up. Raises SampError where nobody can sit or lie.
    """
    if action not in ("sit", "lie"):
        raise SampError(
            f"Goals on an object are for 'sit' and 'lie', not for '{action}'; choose one of these."
        )
    piece = _piece(triangles, action, obstacles, floor_height)
    support, found, grid = piece.support, piece.found, piece.grid
    if not found:
        raise SampError(f"Nobody can {action} on this object; {_advice(action)}.")
    # Samples are held to what the labels were held to: no much worse place than the object's best.
    best = found[0].score
    least, enough = seats.MIN_SCORE_SHARE[action] * best, GOOD * best
    goals: list[Goal] = []
    rejected = 0
    for sample in _network_samples(grid, action, count, seed):
        if len(goals) == count:
            break
        snapped = seats.snap_to_map(support, sample, MOST_SHIFT, least, enough)
        rejected += snapped is None
        goals += [] if snapped is None else [snapped]
    missing = count - len(goals)
    # By turns through the best places, beginning at another one for each seed.
    goals += [found[(seed + k) % len(found)].goal for k in range(missing)]
    return GoalSamples(goals, missing, rejected)


@dataclass(frozen=True)
class _Piece:
    """What all samples on an object share: what carries, the places found by geometry, and what the network sees."""

    support: SupportMap
    found: list[Seat]
    grid: InteractionGrid | None


_pieces: OrderedDict[tuple, _Piece] = OrderedDict()


def _piece(
    triangles: np.ndarray, action: str, obstacles: np.ndarray | None, floor_height: float | None
) -> _Piece:
    """The object as it was looked at before, or looked at now: every take of a batch asks for it again."""
    digest = (
        lambda a: None if a is None else hashlib.blake2b(np.ascontiguousarray(a), digest_size=16).digest()
    )
    key = digest(triangles), digest(obstacles), action, floor_height
    if key not in _pieces:
        support = seats.support_map(triangles, floor_height, obstacles)
        found = seats.seats_on_map(support, action, seats.MANY_SEATS)
        # The front is the object's own, whatever stands around it.
        grid = InteractionGrid.build(triangles, seats.infer_front_yaw(triangles)) if found else None
        _pieces[key] = _Piece(support, found, grid)
    _pieces.move_to_end(key)
    while len(_pieces) > KEPT:
        _pieces.popitem(last=False)
    return _pieces[key]


def _advice(action: str) -> str:
    if action == "lie":
        return "choose one with a flat, free surface of about 1.7 x 0.5 m below 0.85 m"
    return "choose one with a flat, free seat between 0.25 and 0.85 m and room for the legs"


def _network_samples(grid: InteractionGrid, action: str, count: int, seed: int) -> Iterator[Goal]:
    """Goals in the world frame, a few more than are asked for at first, then round by round."""
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
        # One row at a time, so that goal k of a seed does not depend on how many are asked for.
        for _ in range(count + 4):
            z = torch.randn(1, goal_net.LATENT, generator=generator)
            with torch.no_grad():
                goal = net.draw(condition, z)[0].double().numpy()
            facing = goal[3:] @ to_world * [1.0, 0.0, 1.0]
            length = np.linalg.norm(facing)
            if length > 0.2:
                yield Goal(grid.centre + goal[:3] @ to_world, facing / length, action)
