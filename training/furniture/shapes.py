"""Solids as triangles (F, 3, 3), network frame, metres: the primitives of the procedural furniture."""

from __future__ import annotations

import numpy as np


def _quads(grid: np.ndarray) -> np.ndarray:
    """Return the triangles (F, 3, 3) of a grid of points (N, M, 3), two for each cell."""
    a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    return np.concatenate(
        [np.stack([a, b, c], -2).reshape(-1, 3, 3), np.stack([a, c, d], -2).reshape(-1, 3, 3)]
    )


def box(low: tuple[float, float, float], high: tuple[float, float, float], cells: int = 2) -> np.ndarray:
    """Return an axis-aligned box between two corners; ``cells`` squares along each edge of each face."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    s = np.linspace(0, 1, cells + 1)
    u, v = np.meshgrid(s, s, indexing="ij")
    faces = []
    for axis in range(3):
        for side in (0.0, 1.0):
            first, second = (u, v) if side else (v, u)
            unit = np.empty((*u.shape, 3))
            unit[..., axis] = side
            unit[..., (axis + 1) % 3] = first
            unit[..., (axis + 2) % 3] = second
            faces.append(_quads(low + unit * (high - low)))
    return np.concatenate(faces)


def cushion(
    low: tuple[float, float, float], high: tuple[float, float, float], roundness: float = 0.3
) -> np.ndarray:
    """Return a cushion: a superellipsoid that fills the box, squarer for smaller ``roundness`` (0.05 to 1)."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    theta, phi = np.meshgrid(
        np.linspace(-np.pi / 2, np.pi / 2, 13), np.linspace(-np.pi, np.pi, 25), indexing="ij"
    )
    power = lambda x, e: np.sign(x) * np.abs(x) ** e
    ring = power(np.cos(theta), roundness)
    unit = np.stack(
        [
            ring * power(np.sin(phi), roundness),
            power(np.sin(theta), roundness),
            ring * power(np.cos(phi), roundness),
        ],
        axis=-1,
    )
    return _quads((low + high) / 2 + unit * (high - low) / 2)


def tube(path: np.ndarray, radius: float, sides: int = 8) -> np.ndarray:
    """Return a round bar with caps along a polyline (N, 3)."""
    path = np.asarray(path, float)
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    helper = np.where(np.abs(along[:, 1:2]) > 0.9, [[1.0, 0, 0]], [[0, 1.0, 0]])
    u = np.cross(along, helper)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(along, u)
    angle = np.linspace(0, 2 * np.pi, sides + 1)
    rings = path[:, None] + radius * (
        np.cos(angle)[:, None] * u[:, None] + np.sin(angle)[:, None] * v[:, None]
    )
    ends = np.repeat(path[[0, -1]][:, None], sides + 1, axis=1)
    return _quads(np.concatenate([ends[:1], rings, ends[1:]]))


def lathe(profile: np.ndarray, sides: int = 20) -> np.ndarray:
    """Return a body of revolution about the vertical axis; ``profile`` (N, 2) holds radius and height."""
    profile = np.asarray(profile, float)
    angle = np.linspace(0, 2 * np.pi, sides + 1)
    grid = np.stack(
        [
            profile[:, :1] * np.sin(angle),
            np.repeat(profile[:, 1:], sides + 1, axis=1),
            profile[:, :1] * np.cos(angle),
        ],
        axis=-1,
    )
    return _quads(grid)


def disc(radius: float, low: float, high: float, sides: int = 24) -> np.ndarray:
    """Return an upright cylinder with caps between two heights."""
    return lathe(np.array([[1e-6, low], [radius, low], [radius, high], [1e-6, high]]), sides)


def curved_panel(
    width: float, height: float, thickness: float, bow: float, foot: tuple[float, float, float]
) -> np.ndarray:
    """Return an upright panel whose sides curve forward by ``bow``; ``foot`` is the middle of its lower back edge."""
    x, y = np.meshgrid(np.linspace(-1, 1, 13), np.linspace(0, 1, 5), indexing="ij")
    back = np.stack([x * width / 2, y * height, bow * x**2], axis=-1)
    front = back + [0.0, 0.0, thickness]
    rim = lambda a, b: _quads(np.stack([a, b]))
    edges = [
        rim(back[0], front[0]),
        rim(front[-1], back[-1]),
        rim(back[:, 0], front[:, 0]),
        rim(front[:, -1], back[:, -1]),
    ]
    return np.concatenate([_quads(back), _quads(front), *edges]) + np.asarray(foot)


def wall(inner: float, thickness: float, low: float, high: float, half_angle: float) -> np.ndarray:
    """Return a round wall open to the front (+Z), the shell of a tub chair; ``half_angle`` from the back, radians."""
    angle = np.pi + np.linspace(-half_angle, half_angle, 25)
    ring = lambda r, y: np.stack([r * np.sin(angle), np.full_like(angle, y), r * np.cos(angle)], axis=-1)
    outer = inner + thickness
    section = np.stack(
        [ring(inner, low), ring(inner, high), ring(outer, high), ring(outer, low), ring(inner, low)]
    )
    ends = [np.stack([section[:2, k], section[3:1:-1, k]]) for k in (0, -1)]
    return np.concatenate([_quads(section), *[_quads(end) for end in ends]])


def tilted(triangles: np.ndarray, angle: float, pivot: tuple[float, float, float]) -> np.ndarray:
    """Return triangles leaned back by ``angle`` radians about the X axis: points above the pivot move to -Z."""
    c, s = np.cos(-angle), np.sin(-angle)
    turn = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    return (triangles - np.asarray(pivot)) @ turn.T + np.asarray(pivot)


def turned(triangles: np.ndarray, yaw: float) -> np.ndarray:
    """Return the triangles turned about the vertical axis; positive yaw turns left, seen from above."""
    c, s = np.cos(yaw), np.sin(yaw)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    return triangles @ turn.T


def join(parts: list[np.ndarray]) -> np.ndarray:
    """Return all parts as one array of triangles (F, 3, 3), without degenerate triangles."""
    soup = np.concatenate(parts)
    area = np.linalg.norm(np.cross(soup[:, 1] - soup[:, 0], soup[:, 2] - soup[:, 0]), axis=1) / 2
    return soup[area > 1e-10]
