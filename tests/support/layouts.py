"""Floors, stairs, ramps and furniture of boxes and ellipsoids, for tests and benchmarks. Metres, Y up."""

from __future__ import annotations

import numpy as np

WALL, STOREY = 2.6, 3.0
BOX_FACES = np.array(
    [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ]
)  # fmt: skip


def box(low, high):
    """Return the triangles (12, 3, 3) of an axis-aligned box."""
    low, high = np.array(low, dtype=float), np.array(high, dtype=float)
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    return (low + corners * (high - low))[BOX_FACES]


def moved(triangles, yaw=0.0, by=(0, 0, 0)):
    """Rotate triangles about the vertical (radians) and move them."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    return triangles @ np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]]).T + np.asarray(by, dtype=float)


def ball(count, size, centre):
    """Return an ellipsoid of about ``count`` triangles. size: its three half axes."""
    rings = max(int(np.sqrt(count / 2)), 4)
    around, down = np.linspace(0, 2 * np.pi, rings + 1), np.linspace(0, np.pi, rings + 1)[:, None]
    points = np.stack(
        [np.sin(down) * np.cos(around), np.cos(down) + 0 * around, np.sin(down) * np.sin(around)], axis=-1
    ) * np.asarray(size) + np.asarray(centre, dtype=float)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return np.concatenate([np.stack(t, axis=2).reshape(-1, 3, 3) for t in ((a, b, c), (a, c, d))])


def floor(width=6.0, depth=6.0, height=0.0, by=(0, 0)):
    """Return a slab 10 cm thick whose top is at ``height``."""
    x, z = by
    return box((x - width / 2, height - 0.1, z - depth / 2), (x + width / 2, height, z + depth / 2))


def walls(size=8.0):
    """Return four walls around a square room."""
    half = size / 2
    return np.concatenate(
        [
            box((-half, 0, -half - 0.1), (half, WALL, -half)),
            box((-half, 0, half), (half, WALL, half + 0.1)),
            box((-half - 0.1, 0, -half), (-half, WALL, half)),
            box((half, 0, -half), (half + 0.1, WALL, half)),
        ]
    )


def table(by=(0, 0), width=1.6, depth=0.9, height=0.75):
    """Return a table top on four legs."""
    x, z = by
    legs = [
        box((x + a - 0.03, 0, z + b - 0.03), (x + a + 0.03, height, z + b + 0.03))
        for a in (-width / 2 + 0.05, width / 2 - 0.05)
        for b in (-depth / 2 + 0.05, depth / 2 - 0.05)
    ]
    top = box((x - width / 2, height - 0.04, z - depth / 2), (x + width / 2, height, z + depth / 2))
    return np.concatenate([top, *legs])


def sofa(by=(0, 0), yaw=0.0, width=1.8):
    """Return a seat at 45 cm with a back; yaw 0 faces +Z."""
    seat = box((-width / 2, 0.05, -0.4), (width / 2, 0.45, 0.4))
    back = box((-width / 2, 0.45, -0.4), (width / 2, 0.9, -0.25))
    return moved(np.concatenate([seat, back]), yaw, (by[0], 0, by[1]))


def stairs(steps=15, rise=0.2, run=0.28, width=1.2, by=(0, 0)):
    """Return solid steps that rise along +Z from the ground."""
    x, z = by
    return np.concatenate(
        [
            box((x - width / 2, 0, z + k * run), (x + width / 2, (k + 1) * rise, z + (k + 1) * run))
            for k in range(steps)
        ]
    )


def ramp(degrees, rise=1.5, width=1.5, by=(0, 0)):
    """Return a sloping plane that rises along +Z, with a platform at its top."""
    x, z = by
    run = rise / np.tan(np.radians(degrees))
    a, b = np.array((x - width / 2, 0, z)), np.array((x + width / 2, 0, z))
    up = np.array((0, rise, run))
    slope = np.array([(a, b, b + up), (a, b + up, a + up)])
    platform = box((x - 1.5, rise - 0.1, z + run), (x + 1.5, rise, z + run + 3))
    return np.concatenate([slope, platform])


def furnished(seed=0, pieces=12, triangles=90_000, size=8.0):
    """Return a closed room with sofas at random yaws and ellipsoids, of about so many triangles."""
    rng = np.random.default_rng(seed)
    half = size / 2
    parts = [floor(size, size), walls(size), box((-half, WALL, -half), (half, WALL + 0.1, half))]
    for number in range(pieces):
        by = rng.uniform(-half + 0.8, half - 0.8, 2)
        if number % 2:
            parts.append(sofa(by, rng.uniform(0, 2 * np.pi)))
        else:
            parts.append(ball(2 * triangles / pieces, (0.4, 0.5, 0.4), (by[0], 0.5, by[1])))
    return np.concatenate(parts)
