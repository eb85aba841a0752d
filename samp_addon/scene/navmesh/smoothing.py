"""Lines over the ground: their cost, and paths shortened, kept off corners and fitted to the ground's height.

Network frame, metres.
"""

from __future__ import annotations

import numpy as np

from .corridor import ROUGH_COST
from .navmesh import NavMesh

BEND = 0.13
"""Metres. Largest deviation of the ground from the straight line between way-points: less than a stair."""

LONGER = 0.02
"""Largest relative increase of the path length for more clearance at corners."""


def visible(mesh: NavMesh, one: np.ndarray, two: np.ndarray) -> bool:
    """Return whether the straight line between two points (3,) stays on walkable ground."""
    return np.isfinite(line_cost(mesh, one, two))


def project_onto_ground(mesh: NavMesh, flat: np.ndarray, height: float) -> tuple[np.ndarray, np.ndarray]:
    """Project corners (K, 2) onto the ground; return points (M, 3) about a cell apart and the corners' indices (K,).

    height: of the first point, metres, which selects the storey.
    """
    ground, grid = mesh.ground, mesh.ground.grid
    steps = np.maximum(np.ceil(np.linalg.norm(np.diff(flat, axis=0), axis=1) / grid.cell), 1).astype(int)
    corner = np.append(0, np.cumsum(steps))
    across = np.stack([np.interp(np.arange(corner[-1] + 1), corner, flat[:, k]) for k in (0, 1)], axis=1)
    cells = np.floor((across - grid.corner[[0, 2]]) / grid.cell).astype(int)
    found = ground.index[:, cells[:, 0], cells[:, 1]]
    heights = np.where(found >= 0, ground.places.height[found], np.inf)
    line = np.stack([across[:, 0], np.empty(len(across)), across[:, 1]], axis=1)
    for k in range(len(line)):
        gap = np.abs(heights[:, k] - height)
        if gap.min() <= mesh.agent.height / 2:
            height = heights[gap.argmin(), k]
        line[k, 1] = height
    return line, corner


def line_cost(mesh: NavMesh, one: np.ndarray, two: np.ndarray) -> float:
    """Return the length of a straight line, weighted on rough ground as in the search; infinite off the ground."""
    length = float(np.linalg.norm(two - one))
    share = np.linspace(0, 1, int(np.ceil(2 * length / mesh.ground.grid.cell)) + 2)[:, None]
    places = mesh.ground.at(one + share * (two - one))
    owner = mesh.pieces.owner[places]
    if (places < 0).any() or (owner < 0).any():
        return np.inf
    rise = np.abs(np.diff(mesh.ground.places.height[places]))
    if (rise > mesh.agent.step + 0.05).any():
        return np.inf
    return length * float(np.where(mesh.pieces.rough[owner], ROUGH_COST, 1.0).mean())


def shorten(mesh: NavMesh, corners: np.ndarray) -> np.ndarray:
    """Remove corners that a straight line can skip at no higher cost."""
    cost = np.array([line_cost(mesh, a, b) for a, b in zip(corners, corners[1:], strict=False)])
    # The pulled line may graze a cell off the ground; use its plain length there.
    cost = np.where(np.isfinite(cost), cost, np.linalg.norm(np.diff(corners, axis=0), axis=1))
    spent = np.append(0, np.cumsum(cost))
    kept, at = [0], 0
    while at < len(corners) - 1:
        ahead = (
            k
            for k in range(len(corners) - 1, at + 1, -1)
            if line_cost(mesh, corners[at], corners[k]) <= spent[k] - spent[at] + 1e-6
        )
        at = next(ahead, at + 1)
        kept.append(at)
    return corners[kept]


def widen_corners(mesh: NavMesh, corners: np.ndarray, comfort: float) -> np.ndarray:
    """Move corners away from obstacles, up to ``comfort`` metres beyond the character's radius.

    The path grows by at most the share LONGER of its length.
    """
    corners = corners.copy()
    budget = LONGER * np.linalg.norm(np.diff(corners, axis=0), axis=1).sum()
    for k in range(1, len(corners) - 1):
        before, after = corners[k - 1], corners[k + 1]
        for place in _roomier_places(mesh, corners[k], comfort):
            longer = _detour(before, place, after) - _detour(before, corners[k], after)
            if longer <= budget and visible(mesh, before, place) and visible(mesh, place, after):
                corners[k] = place
                budget -= longer
                break
    return corners


def _detour(before: np.ndarray, place: np.ndarray, after: np.ndarray) -> float:
    return float(np.linalg.norm(place - before) + np.linalg.norm(after - place))


def _roomier_places(mesh: NavMesh, corner: np.ndarray, comfort: float) -> np.ndarray:
    """Return up to 12 places (K, 3) near a corner with more clearance, best first."""
    ground, grid = mesh.ground, mesh.ground.grid
    here = ground.at(corner)
    wanted = mesh.agent.radius + comfort
    room = ground.clearance[here]
    if here < 0 or room >= wanted:
        return np.zeros((0, 3))
    reach = int(np.ceil(2 * comfort / grid.cell))
    x, z = ground.places.x[here], ground.places.z[here]
    window = ground.index[:, max(x - reach, 0) : x + reach + 1, max(z - reach, 0) : z + reach + 1]
    near = window[(window >= 0) & (mesh.pieces.owner[window] >= 0)]
    points = ground.points(near)
    near_height = np.abs(points[:, 1] - corner[1]) <= mesh.agent.step
    gain = np.minimum(ground.clearance[near], wanted) - room
    away = np.linalg.norm(points - corner, axis=1)
    good = np.flatnonzero(near_height & (gain > 0.01))
    return points[good[np.argsort(0.3 * away[good] - gain[good], kind="stable")]][:12]


def add_height_waypoints(mesh: NavMesh, corners: np.ndarray) -> np.ndarray:
    """Insert way-points between corners (K, 3) where the ground rises or falls."""
    line, corner = project_onto_ground(mesh, corners[:, [0, 2]], corners[0, 1])
    kept = set(corner.tolist())
    waiting = list(zip(corner[:-1].tolist(), corner[1:].tolist(), strict=True))
    while waiting:
        a, b = waiting.pop()
        if b - a < 2:
            continue
        straight = np.interp(np.arange(a, b + 1), [a, b], line[[a, b], 1])
        off = np.abs(line[a : b + 1, 1] - straight)
        if off.max() > BEND:
            middle = a + int(off.argmax())
            kept.add(middle)
            waiting += [(a, middle), (middle, b)]
    return line[sorted(kept)]
