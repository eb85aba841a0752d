"""Fit the seated pose to a seat: depth and height of the resting pelvis, trunk against the back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .shapes import posing, probes
from .shapes.surfaces import NOTHING, SeatSurface

MODES = ("leaning", "upright", "perching")
BUTTOCK = 0.13  # metres from the pelvis joint back to the rear of the buttocks
THIGH = 0.36  # metres from the pelvis joint forward to the hollow of the knee
SOFT_EDGE = 0.09  # metres by which the hollow of the knee may be behind a soft edge
PRESSED = 0.004  # compression of flesh, metres
TOUCHING = 10  # vertices averaged to measure a contact
MOST_LEAN = np.radians(33)  # largest backward lean of the seated trunk
STEPS = 7
_SIGMA = np.array([0.03, 0.10, 0.16, 0.20, 0.03])
_TRUST = np.array([2.0, 0.1, 0.5, 0.5, 0.5])
"""Priors of depth, height, pelvis' pitch, spine's pitch and raised heels."""
_STEP = np.array([2e-3, 2e-3, 5e-3, 5e-3, 2e-3])
_MOST_STEP = np.array([0.04, 0.04, 0.12, 0.12, 0.03])
MOST_HEELS = 0.09


@dataclass(frozen=True)
class Hold:
    """A seated pose: depth (z) and height (y) of the pelvis in the seat frame, metres.

    pelvis, spine: radians bent forward from the captured pose. heels: metres by which heels are raised. gap: metres
    between back and rest, 1 without one. pressed: largest penetration of the seat, metres.
    """

    mode: str
    depth: float
    height: float
    pelvis: float
    spine: float
    heels: float
    gap: float
    pressed: float


def depth_of(surface: SeatSurface, mode: str, give: float, rng: np.random.Generator) -> float | None:
    """Return the pelvis' z, metres in the seat frame, of a mode of sitting; None where the seat does not allow it."""
    behind = surface.rear + BUTTOCK + (0.0 if surface.backed else -0.03)
    by_knees = (
        surface.edge - THIGH - (SOFT_EDGE if give else 0.0)
    )  # any deeper, the calves would be in the cushion
    deepest = max(behind, by_knees)
    if mode == "leaning":
        return deepest if surface.backed and deepest - surface.rest < 0.40 else None
    if mode == "perching":
        forward = surface.edge - rng.uniform(0.10, 0.20)
        return forward if forward > deepest + 0.05 else None
    forward = surface.edge - 0.16
    if surface.backed:
        return min(deepest + rng.uniform(0.02, 0.10), max(forward, deepest))
    wanted = surface.edge - rng.uniform(0.20, 0.34)
    return float(np.clip(wanted, deepest, max(forward, deepest)))


def solve(
    root: np.ndarray, rotations: np.ndarray, feet: tuple[dict, dict], surface: SeatSurface, mode: str, depth: float,
    give: float, lean: float,
) -> Hold:  # fmt: skip
    """Return the hold of one pose in the seat frame, by Levenberg-Marquardt.

    root: (3,), rotations: (22, 4), as captured, raised to the approximate seat height. feet: fixed ankles and feet of
    one frame, as returned by posing.ankles. depth: wanted z of the pelvis. lean: initial backward lean, radians.
    """

    def posed(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        count = len(values)
        turned = posing.leant(np.repeat(rotations[None], count, 0), values[:, 2], values[:, 3])
        at = np.column_stack([np.full(count, root[0]), values[:, 1], values[:, 0]])
        places, turns = ({s: np.repeat(v, count, 0) for s, v in part.items()} for part in feet)
        places, turns = posing.tiptoed(places, turns, np.clip(values[:, 4], 0.0, MOST_HEELS))
        return at, posing.planted(at, turned, places, turns)

    start = np.array([depth, root[1], -0.5 * lean, -0.5 * lean, 0.0])
    values = start.copy()
    damping = 1e-2
    best = _residual(*posed(values[None]), values[None], start, surface, mode, give)[0]
    for _ in range(STEPS):
        tried = np.concatenate([values[None], values + np.diag(_STEP)])
        residual = _residual(*posed(tried), tried, start, surface, mode, give)
        slope = (residual[1:] - residual[0]).T / _STEP
        normal = slope.T @ slope
        move = -np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-6), slope.T @ residual[0])
        new = values + np.clip(move, -_MOST_STEP, _MOST_STEP)
        new[4] = np.clip(new[4], 0.0, MOST_HEELS)
        found = _residual(*posed(new[None]), new[None], start, surface, mode, give)[0]
        if found @ found < best @ best:
            done = np.abs(new - values).max() < 5e-4
            values, best, damping = new, found, max(damping / 4, 1e-4)
            if done:
                break
        else:
            damping *= 6
    at, turned = posed(values[None])
    gap, over = back_gap(at, turned, surface)[0], seat_gap(at, turned, surface)[1][0]
    return Hold(mode, *(float(v) for v in values), float(gap), float(-over))


def _residual(root, rotations, values, start, surface, mode, give) -> np.ndarray:  # noqa: ANN001
    """Return residuals (B, R) of poses, centimetres."""
    seat = probes.skinned(root, rotations, probes.load().seat)
    over = seat[..., 1] - surface.height_at(seat[..., 0], seat[..., 2])
    inside = np.maximum(-over - give, 0.0)
    touch = np.sort(over, 1)[:, :TOUCHING].mean(1) + PRESSED + 0.5 * give
    parts = [30 * inside, 100 * touch[:, None]]
    back = probes.skinned(root, rotations, probes.load().back)
    ahead = _ahead(back, surface)
    parts.append(30 * np.maximum(-ahead - give, 0.0))
    if mode == "leaning":
        parts.append(60 * _nearest(root, rotations, surface, give)[:, None])
    parts.append((values - start) / _SIGMA * _TRUST)
    return np.concatenate(parts, 1)


def _nearest(root: np.ndarray, rotations: np.ndarray, surface: SeatSurface, give: float) -> np.ndarray:
    """Return the distance (B,), metres, between upper back and rest: mean of the nearest vertices, at most 0.25."""
    upper = probes.skinned(root, rotations, probes.load().upper_back)
    ahead = np.clip(np.sort(_ahead(upper, surface), 1)[:, :8].mean(1) + 0.5 * give, -0.25, 0.25)
    return ahead


def _ahead(points: np.ndarray, surface: SeatSurface) -> np.ndarray:
    """Return the distance, metres, of points (..., 3) in front of the back's face; large where there is none."""
    face = surface.back_at(points[..., 0], points[..., 1])
    return np.where(face > NOTHING / 2, points[..., 2] - face, 1.0)


def back_gap(root: np.ndarray, rotations: np.ndarray, surface: SeatSurface) -> np.ndarray:
    """Return the distance (T,), metres, between trunk and rest at the nearest vertices; negative inside; 1 without."""
    back = probes.skinned(root, rotations, probes.load().back)
    return np.sort(_ahead(back, surface), 1)[:, :4].mean(1)


def seat_gap(root: np.ndarray, rotations: np.ndarray, surface: SeatSurface) -> tuple[np.ndarray, np.ndarray]:
    """Return distances (T,), metres, of buttocks and thighs over the seat: mean of the nearest, and minimum."""
    seat = probes.skinned(root, rotations, probes.load().seat)
    over = np.sort(seat[..., 1] - surface.height_at(seat[..., 0], seat[..., 2]), 1)
    return over[:, :TOUCHING].mean(1), over[:, 0]


def back_distances(
    root: np.ndarray, rotations: np.ndarray, surface: SeatSurface
) -> tuple[np.ndarray, np.ndarray]:
    """Return the trunk's rear vertices: height over the pelvis (T, B), distance in front of the back (T, B), metres.

    The distance is 1 where there is no back.
    """
    back = probes.skinned(root, rotations, probes.load().back)
    return back[..., 1] - root[:, None, 1], _ahead(back, surface)
