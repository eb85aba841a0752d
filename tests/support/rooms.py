"""Rooms of boxes: a seat at a random yaw, five obstacles around it, and a start behind one of them.

Network frame, metres, Y up. Pieces are at least 0.8 m apart, so that a path always exists.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from samp_blender.samp_addon import frames

SIZE = 8.0
GAP = 0.8


def box(low, high):
    """Return the outward-facing triangles (12, 3, 3) of a box."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    quads = [
        [(x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)],
        [(x1, y0, z0), (x1, y1, z0), (x1, y1, z1), (x1, y0, z1)],
        [(x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)],
        [(x0, y1, z0), (x0, y1, z1), (x1, y1, z1), (x1, y1, z0)],
        [(x0, y0, z0), (x0, y1, z0), (x1, y1, z0), (x1, y0, z0)],
        [(x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)],
    ]
    return np.array([[q[0], *pair] for q in quads for pair in (q[1:3], q[2:4])], dtype=float)


def chair(rng):
    """Return the boxes of a seat on legs with a back; faces +Z."""
    w, d, h = rng.uniform(0.42, 0.52), rng.uniform(0.42, 0.5), rng.uniform(0.42, 0.48)
    boxes = [((-w / 2, h - 0.05, -d / 2), (w / 2, h, d / 2))]
    boxes += [((-w / 2, h, -d / 2), (w / 2, h + 0.45, -d / 2 + 0.04))]
    for x in (-w / 2, w / 2 - 0.04):
        for z in (-d / 2, d / 2 - 0.04):
            boxes.append(((x, 0, z), (x + 0.04, h - 0.05, z + 0.04)))
    return boxes


def sofa(rng):
    """Return the boxes of a sofa with arms and a back; faces +Z."""
    w, d, h = rng.uniform(1.4, 2.1), rng.uniform(0.8, 0.95), rng.uniform(0.40, 0.46)
    return [
        ((-w / 2, 0.06, -d / 2), (w / 2, h, d / 2)),
        ((-w / 2, 0.06, -d / 2), (w / 2, h + 0.4, -d / 2 + 0.22)),
        ((-w / 2, 0.06, -d / 2), (-w / 2 + 0.18, h + 0.2, d / 2)),
        ((w / 2 - 0.18, 0.06, -d / 2), (w / 2, h + 0.2, d / 2)),
    ]


def armchair(rng):
    """Return the boxes of an armchair; faces +Z."""
    w, d, h = rng.uniform(0.8, 0.95), rng.uniform(0.75, 0.9), rng.uniform(0.38, 0.44)
    return [
        ((-w / 2, 0.05, -d / 2), (w / 2, h, d / 2)),
        ((-w / 2, 0.05, -d / 2), (w / 2, h + 0.45, -d / 2 + 0.2)),
        ((-w / 2, 0.05, -d / 2), (-w / 2 + 0.14, h + 0.18, d / 2)),
        ((w / 2 - 0.14, 0.05, -d / 2), (w / 2, h + 0.18, d / 2)),
    ]


def bed(rng):
    w, d, h = rng.uniform(0.9, 1.8), rng.uniform(1.95, 2.15), rng.uniform(0.38, 0.56)
    return [
        ((-w / 2, 0, -d / 2), (w / 2, h, d / 2)),
        ((-w / 2, 0, -d / 2 - 0.08), (w / 2, h + rng.uniform(0.3, 0.6), -d / 2)),
    ]


SEATS = (chair, sofa, armchair)


def table(rng):
    w, d, h = rng.uniform(0.8, 1.4), rng.uniform(0.6, 0.9), rng.uniform(0.70, 0.76)
    boxes = [((-w / 2, h - 0.04, -d / 2), (w / 2, h, d / 2))]
    for x in (-w / 2, w / 2 - 0.06):
        for z in (-d / 2, d / 2 - 0.06):
            boxes.append(((x, 0, z), (x + 0.06, h - 0.04, z + 0.06)))
    return boxes


def cabinet(rng):
    w, d, h = rng.uniform(0.8, 1.4), rng.uniform(0.35, 0.6), rng.uniform(0.8, 1.9)
    return [((-w / 2, 0, -d / 2), (w / 2, h, d / 2))]


def crate(rng):
    s = rng.uniform(0.5, 0.8)
    return [((-s / 2, 0, -s / 2), (s / 2, rng.uniform(0.4, 0.9), s / 2))]


OBSTACLES = (table, cabinet, crate)


def turned(points, yaw):
    """Rotate points (..., 3) about the vertical; yaw in radians."""
    c, s = np.cos(yaw), np.sin(yaw)
    return points @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]).T


@dataclass(frozen=True)
class Piece:
    """A piece of furniture. boxes: (low, high) corners around the origin. at: (x, z), metres. yaw: radians."""

    name: str
    boxes: list
    at: np.ndarray
    yaw: float

    @property
    def triangles(self):
        points = np.concatenate([box(low, high) for low, high in self.boxes])
        return turned(points, self.yaw) + [self.at[0], 0, self.at[1]]

    @property
    def half(self):
        """Half sizes (2,) of the footprint along its own axes; pieces are centred at the origin."""
        corners = np.array(self.boxes).reshape(-1, 3)
        return np.abs(corners[:, [0, 2]]).max(0)

    def covers(self, points, margin=0.0):
        """Flag the points (N, 3) over the footprint."""
        local = turned(points - [self.at[0], 0, self.at[1]], -self.yaw)
        return (np.abs(local[:, [0, 2]]) <= self.half + margin).all(-1)


@dataclass(frozen=True)
class Room:
    """A room. pieces: the target first. start: (3,) on the floor, metres. start_yaw: radians."""

    pieces: list
    start: np.ndarray
    start_yaw: float

    @property
    def target(self):
        return self.pieces[0]

    @property
    def floor(self):
        return box((-SIZE / 2, -0.1, -SIZE / 2), (SIZE / 2, 0, SIZE / 2))

    @property
    def triangles(self):
        return np.concatenate([self.floor, *(piece.triangles for piece in self.pieces)])

    def crossings(self, waypoints):
        """Return the names of the pieces whose footprints the path (N, 3) crosses."""
        waypoints = np.asarray(waypoints, float)
        parts = [np.linspace(a, b, 200) for a, b in zip(waypoints[:-1], waypoints[1:], strict=True)]
        points = np.concatenate(parts) if parts else waypoints
        return [piece.name for piece in self.pieces if piece.covers(points, -0.01).any()]


def random_room(seed, target=None):
    """Return the room of a seed. target: one of SEATS; random if left out."""
    rng = np.random.default_rng(seed)
    make = target or SEATS[int(rng.integers(len(SEATS)))]
    yaw = float(rng.uniform(-np.pi, np.pi))
    seat = Piece(make.__name__.capitalize(), make(rng), rng.uniform(-0.8, 0.8, 2), yaw)
    for _ in range(1000):
        placed = _start_behind_an_obstacle(seat, rng)
        if placed is not None:
            blocker, start = placed
            others = _scattered([seat, blocker], start, rng)
            if others is not None:
                return Room([seat, blocker, *others], start, float(rng.uniform(-np.pi, np.pi)))
    raise AssertionError("no room found")


def _radius(piece):
    return float(np.linalg.norm(piece.half))


def _obstacle(number, rng):
    make = OBSTACLES[int(rng.integers(len(OBSTACLES)))]
    limit = SIZE / 2 - 1.0
    return Piece(f"Obstacle {number}", make(rng), rng.uniform(-limit, limit, 2), float(rng.uniform(0, np.pi)))


def _apart(piece, others):
    return all(
        np.linalg.norm(piece.at - other.at) > _radius(piece) + _radius(other) + GAP for other in others
    )


def _start_behind_an_obstacle(seat, rng):
    """Return an obstacle and a start from which it blocks the straight line to the seat, or None."""
    front = frames.yaw_direction(seat.yaw)[[0, 2]]
    goal = seat.at + front * 0.6
    piece = _obstacle(1, rng)
    away = piece.at - goal
    distance = np.linalg.norm(away)
    if not _apart(piece, [seat]) or distance < 1.2:
        return None
    start = piece.at + away / distance * (_radius(piece) + 0.5)
    if np.abs(start).max() > SIZE / 2 - 0.6 or np.linalg.norm(start - seat.at) < _radius(seat) + 0.8:
        return None
    line = np.linspace([start[0], 0, start[1]], [goal[0], 0, goal[1]], 200)
    return (piece, np.array([start[0], 0.0, start[1]])) if piece.covers(line).any() else None


def _scattered(placed, start, rng):
    """Return four more obstacles, away from other pieces, the start and the space in front of the seat, or None."""
    seat, obstacles = placed[0], []
    ahead = seat.at + frames.yaw_direction(seat.yaw)[[0, 2]] * (seat.half[1] + 0.6)
    for _ in range(400):
        piece = _obstacle(len(obstacles) + 2, rng)
        clear = min(np.linalg.norm(piece.at - start[[0, 2]]), np.linalg.norm(piece.at - ahead))
        if clear > _radius(piece) + 0.6 and _apart(piece, placed + obstacles):
            obstacles.append(piece)
        if len(obstacles) == 4:
            return obstacles
    return None


def to_blender(room, scene):
    """Add the room's objects to a scene; return the start as in the batch (x, y, z, yaw in degrees)."""
    import bpy

    for name, triangles in [("Floor", room.floor)] + [(p.name, p.triangles) for p in room.pieces]:
        mesh = bpy.data.meshes.new(name)
        points = frames.to_blender(triangles.reshape(-1, 3))
        mesh.from_pydata(points.tolist(), [], np.arange(len(points)).reshape(-1, 3).tolist())
        scene.collection.objects.link(bpy.data.objects.new(name, mesh))
    return [*frames.to_blender(room.start).tolist(), float(np.degrees(room.start_yaw))]
