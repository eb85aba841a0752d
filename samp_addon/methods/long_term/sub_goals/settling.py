"""A single body put onto what carries it: a standing one onto the floor, a seated or lying one fitted to its furniture.

Network frame, metres.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .... import rotation, skeleton
from ....body import balls, human
from ....body import betas as shapes
from ....frames import yaw_direction
from ....refine.feet.grounding import sole_heights
from ....scene.distance.signed_distance import BAND, SignedDistance
from ..figure import Figure, as_motion

LIFTS = np.arange(-0.08, 0.081, 0.01)
"""Metres by which a resting body is raised or lowered to touch what carries it."""
TOUCHING = 0.005
CHANGES = ("ahead", "up", "lean", "hips", "knees")
"""What is changed to fit a body: metres along its facing and up; radians by which the trunk turns back while the legs
stay, the thighs are raised, and the knees bent. The feet keep their angle to the floor."""
SIGMA = np.array([0.05, 0.04, 0.12, 0.12, 0.20])
"""Usual sizes of the changes: of the first round, and of what costs as much as TRUST metres of depth."""
TRUST = 0.004
HANGING = 0.6
"""Cost of a metre between the floor and the feet of a body that sits."""
ROUNDS, TRIED, KEPT = 4, 32, 6
"""Rounds of the cross-entropy method, bodies tried in each, and those kept for the next one."""
EVERY = 4
"""Step through the 2,048 points of the skin."""
SEAT, LOWEST = 0.22, 0.06
"""Metres around the pelvis, horizontally, in which skin rests on a seat, and over its lowest point there: elbows on
armrests carry nobody."""
LEGS = ("hip", "knee", "ankle")
ACROSS = np.array([1.0, 0.0, 0.0])


def grounded(figure: Figure, floor: float) -> Figure:
    """Return a standing figure with its lowest skin on the floor."""
    body = shapes.body_of(figure.betas)
    # Rounded: the last bits of the skin depend on the number of threads, and takes must not.
    lowest = round(float(human.skin(body, as_motion([figure]), body.collision)[0, :, 1].min()), 5)
    return figure.moved(np.array([0.0, floor - lowest, 0.0]))


def settled(
    figures: Sequence[Figure], field: SignedDistance, floor: float
) -> tuple[list[Figure], np.ndarray]:
    """Return resting figures at the heights at which they fit best, and their costs (K,)."""
    costs = fits(figures, field, floor, LIFTS)
    best = costs.argmin(1)
    moved = [figure.moved(np.array([0.0, LIFTS[k], 0.0])) for figure, k in zip(figures, best, strict=True)]
    return moved, costs.min(1)


def fits(
    figures: Sequence[Figure], field: SignedDistance, floor: float, lifts: Sequence[float] = (0.0,)
) -> np.ndarray:
    """Return how badly figures fit at some heights (K, L): depth of the body, distance of the skin that should rest.

    The depth of the skin is 0 behind a thin layer that it has passed through, such as a blanket or a thin seat; the
    balls inside the skin have a depth there.
    """
    body, motion = shapes.body_of(figures[0].betas), as_motion(figures)
    skin = human.skin(body, motion, body.collision[::EVERY]).astype(np.float64)
    inner = balls.of_body(body)
    centres, radii = inner.at(motion).astype(np.float64), np.minimum(inner.radii, BAND)
    roots = np.array([figure.root for figure in figures])
    resting = np.linalg.norm((skin - roots[:, None])[..., [0, 2]], axis=-1) < SEAT
    lowest = np.where(resting, skin[..., 1], np.inf).min(1, keepdims=True)
    resting &= skin[..., 1] < lowest + LOWEST
    costs = np.empty((len(figures), len(lifts)))
    for column, lift in enumerate(lifts):
        distance, free = (_distances(points + [0.0, lift, 0.0], field, floor) for points in (skin, centres))
        depth, inside = (np.maximum(value - TOUCHING, 0) for value in (-distance, radii - free))
        nearest = np.sort(np.where(resting, distance, np.inf), 1)[:, :10]
        costs[:, column] = sum(20 * deep.mean(1) + deep.max(1) for deep in (depth, inside))
        costs[:, column] += np.abs(nearest).mean(1)
    return costs


def _distances(points: np.ndarray, field: SignedDistance, floor: float) -> np.ndarray:
    """Return the distances (K, N) of points (K, N, 3) from surfaces and floor, negative inside."""
    flat = points.reshape(-1, 3)
    return np.minimum(field.at(flat)[0], flat[:, 1] - floor).reshape(points.shape[:2])


def fitted(figure: Figure, field: SignedDistance, floor: float, action: str, seed: int) -> Figure:
    """Return a resting figure moved and bent by CHANGES so that it neither floats nor is in its furniture.

    Found by the cross-entropy method (Rubinstein 1999) from the figure itself; the result depends on ``seed`` only.
    """
    rng = np.random.default_rng(seed)
    middle, sigma = np.zeros(len(CHANGES)), SIGMA.copy()
    best, least = middle, np.inf
    for _ in range(ROUNDS):
        tried = middle + sigma * rng.standard_normal((TRIED, len(CHANGES)))
        tried[0] = middle
        bodies = changed(figure, tried, action)
        costs = fits(bodies, field, floor)[:, 0] + TRUST * np.square(tried / SIGMA).sum(1)
        if action == "sit":
            costs += HANGING * np.maximum(sole_heights(as_motion(bodies)) - floor, 0).mean(1)
        costs = np.round(costs, 6)
        order = costs.argsort(kind="stable")[:KEPT]
        if costs[order[0]] < least:
            best, least = tried[order[0]], costs[order[0]]
        middle, sigma = tried[order].mean(0), tried[order].std(0) + 0.1 * sigma
    return changed(figure, best[None], action)[0]


def changed(figure: Figure, values: np.ndarray, action: str) -> list[Figure]:
    """Return a figure with changes (K, 5), see CHANGES."""
    ahead = yaw_direction(figure.facing(action))
    root = figure.root + values[:, :1] * ahead + values[:, 1:2] * np.array([0.0, 1.0, 0.0])
    turns = np.repeat(figure.rotations[None], len(values), 0)
    lean, hips, knees = values[:, 2], values[:, 3], values[:, 4]
    turn = lambda angle: rotation.from_axis_angle(angle[:, None] * ACROSS)
    turns[:, 0] = rotation.multiply(turns[:, 0], turn(-lean))
    for side in ("left", "right"):
        hip, knee, ankle = (skeleton.INDEX[f"{side}_{part}"] for part in LEGS)
        turns[:, hip] = rotation.multiply(turn(lean - hips), turns[:, hip])
        turns[:, knee] = rotation.multiply(turns[:, knee], turn(knees))
        turns[:, ankle] = rotation.multiply(turn(hips - knees), turns[:, ankle])
    return [replace(figure, root=at, rotations=turned) for at, turned in zip(root, turns, strict=True)]
