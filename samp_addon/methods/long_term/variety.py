"""What differs between takes beside the networks' noise, which PoseNet hardly hears: ways, pace, strides and pauses.

Everything follows from the generator that is given. scale: the standard deviation of all noise of a take, about 1.
Network frame, metres.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...frames import ground_lengths
from ...scene.navmesh.navmesh import NavMesh
from . import way

BOW, SHARE = 0.35, 0.12
"""Metres by which a way is bowed sideways at most, and share of its length."""
LEAST = 1.0
"""Metres of the shortest way that is bowed."""
SPACING = 0.1
"""Metres between the points of a bowed way."""
TRIED = (1.0, -1.0, 0.5, -0.5)
"""Factors on the bow, until there is room for it."""
ROOM = 0.1
"""Metres of clearance that a bowed way keeps beyond the walker's radius."""
FLAT = 0.03
"""Metres of height by which a way may go up and down where it is bowed."""
PACE, STRIDE, PAUSE = 0.2, 0.1, 0.3
"""Largest changes, as shares: of the pace and the length of a stride between two sub-goals, and of a pause."""


@dataclass(frozen=True)
class Gait:
    """How somebody walks from one sub-goal to the next: factors on the usual pace and on the length of a stride."""

    pace: float = 1.0
    stride: float = 1.0


def gait(rng: np.random.Generator, scale: float) -> Gait:
    """Return a random gait. Faster gaits have longer strides."""
    fast, long = rng.uniform(-scale, scale, 2)
    return Gait(float(1 + PACE * fast), float(1 + STRIDE * (fast + long) / 2))


def pause(seconds: float, rng: np.random.Generator, scale: float) -> float:
    """Return a pause of about some seconds."""
    return float(seconds * (1 + PAUSE * rng.uniform(-scale, scale)))


def bowed(mesh: NavMesh, line: np.ndarray, rng: np.random.Generator, scale: float) -> np.ndarray:
    """Return a way (N, 3) over walkable ground between the same ends, bowed to a side where there is room for that.

    It leaves and reaches its ends in the same directions.
    """
    at = ground_lengths(line)
    wide = rng.uniform(-scale, scale) * min(BOW, SHARE * at[-1])
    if at[-1] < LEAST or np.ptp(line[:, 1]) > FLAT:
        return line
    points = way.resampled(line, int(np.ceil(at[-1] / SPACING)) + 1)
    ahead = np.gradient(points[:, [0, 2]], axis=0)
    ahead /= np.maximum(np.linalg.norm(ahead, axis=-1, keepdims=True), 1e-9)
    side = np.stack([ahead[:, 1], np.zeros(len(points)), -ahead[:, 0]], axis=-1)
    course = np.square(np.sin(np.pi * np.linspace(0, 1, len(points))))[:, None]
    for factor in TRIED:
        moved = points + factor * wide * course * side
        if _has_room(mesh, moved[1:-1], points[1:-1]):
            return np.concatenate([line[:1], moved[1:-1], line[-1:]])
    return line


def _has_room(mesh: NavMesh, moved: np.ndarray, points: np.ndarray) -> bool:
    """Return whether all points (N, 3) of a way are on level ground with room around, or no closer to things than those
    (N, 3) they were moved from."""
    old, new = (mesh.ground.at(line) for line in (points, moved))
    if (new < 0).any() or (mesh.pieces.owner[new] < 0).any():
        return False
    clearance = mesh.ground.clearance
    before = np.where(old >= 0, clearance[np.maximum(old, 0)], 0.0)
    level = np.abs(mesh.heights_at(moved) - points[:, 1]) < FLAT
    return bool((level & (clearance[new] >= np.minimum(before, mesh.agent.radius + ROOM))).all())
