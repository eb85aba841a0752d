"""A* search over the convex polygons of the navmesh (SAMP, appendix E)."""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np

from .navmesh import NavMesh

SPACING = 0.25
"""Metres between the points on a portal that the search considers."""
ROUGH_COST = 10.0
"""Cost of a metre over rough ground relative to even ground: paths go round a toy box, not over it."""


@dataclass(frozen=True)
class _States:
    """Search states: points on portals, each with the polygon that is entered there.

    points: (S, 3) metres. portal, entered: (S,) indices. leaving: for each polygon the states that leave it.
    """

    points: np.ndarray
    portal: np.ndarray
    entered: np.ndarray
    leaving: list[np.ndarray]


def search(mesh: NavMesh, start: np.ndarray, goal: np.ndarray, first: int, last: int) -> list[int] | None:
    """Return the portals of a short path from start (3,) in polygon ``first`` to goal (3,) in ``last``, or None.

    Lengths are measured through points on the portals, which is slightly more than the final path has.
    """
    if first == last:
        return []
    states = _states(mesh)
    cost = np.where(mesh.pieces.rough, ROUGH_COST, 1.0)
    to_goal = np.linalg.norm(states.points - goal, axis=1)
    best = np.full(len(states.points), np.inf)
    parent = np.full(len(states.points), -1)
    queue: list[tuple[float, int]] = []

    def relax(polygon: int, here: np.ndarray, spent: float, origin: int) -> None:
        onward = states.leaving[polygon]
        total = spent + cost[polygon] * np.linalg.norm(states.points[onward] - here, axis=1)
        better = total < best[onward] - 1e-9
        onward, total = onward[better], total[better]
        best[onward], parent[onward] = total, origin
        for state, estimate in zip(onward.tolist(), (total + to_goal[onward]).tolist(), strict=True):
            heapq.heappush(queue, (estimate, state))

    relax(first, start, 0.0, -1)
    reached, shortest = -1, np.inf
    done = np.zeros(len(states.points), dtype=bool)
    while queue and queue[0][0] < shortest:
        state = heapq.heappop(queue)[1]
        if done[state]:
            continue
        done[state] = True
        polygon = int(states.entered[state])
        if polygon == last:
            total = best[state] + cost[last] * to_goal[state]
            if total < shortest:
                reached, shortest = state, total
        else:
            relax(polygon, states.points[state], float(best[state]), state)
    return None if reached < 0 else _trace_back(states, parent, reached)


def _trace_back(states: _States, parent: np.ndarray, state: int) -> list[int]:
    portals = []
    while state >= 0:
        portals.append(int(states.portal[state]))
        state = int(parent[state])
    return portals[::-1]


def _states(mesh: NavMesh) -> _States:
    ends, pieces = mesh.portals.ends, mesh.portals.pieces
    steps = np.ceil(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / SPACING).astype(int)
    portal = np.repeat(np.arange(len(ends)), steps + 1)
    step = np.arange(len(portal)) - np.repeat(np.cumsum(steps + 1) - steps - 1, steps + 1)
    share = (step / np.maximum(steps, 1)[portal])[:, None]
    points = ends[portal, 0] * (1 - share) + ends[portal, 1] * share
    left = np.concatenate([pieces[portal, 0], pieces[portal, 1]])
    entered = np.concatenate([pieces[portal, 1], pieces[portal, 0]])
    order = np.argsort(left, kind="stable")
    leaving = np.split(order, np.searchsorted(left[order], np.arange(1, len(mesh.pieces))))
    return _States(np.tile(points, (2, 1)), np.tile(portal, 2), entered, leaving)
