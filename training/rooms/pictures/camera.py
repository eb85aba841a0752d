"""Cameras with plausible heights and lenses and a person in view."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..layout.room import Room

SIZE = (256, 144)  # width and height of a picture
HEIGHTS = (0.9, 2.3)  # metres over the floor
LENSES = (50.0, 84.0)  # degrees, horizontal field of view
WALL_GAP = 0.15  # metres between a camera and a wall


@dataclass(frozen=True)
class Camera:
    """A pinhole camera with square pixels.

    position: (3,) metres. axes: (3, 3), rows are the camera's right, up and backward directions in the room. lens:
    horizontal field of view, radians.
    """

    position: np.ndarray
    axes: np.ndarray
    lens: float

    def intrinsics(self, size: tuple[int, int] = SIZE) -> np.ndarray:
        """Return the matrix (3, 3) from camera coordinates (x right, y down, z forward) to pixels."""
        width, height = size
        focal = width / 2 / np.tan(self.lens / 2)
        return np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1.0]])

    def extrinsics(self) -> np.ndarray:
        """Return the matrix (4, 4) from the room to camera coordinates (x right, y down, z forward)."""
        out = np.eye(4)
        out[:3, :3] = self.axes * np.array([[1.0], [-1.0], [-1.0]])
        out[:3, 3] = -out[:3, :3] @ self.position
        return out

    def rays(self, size: tuple[int, int] = SIZE, jitter: np.ndarray | None = None) -> np.ndarray:
        """Return unit directions (height, width, 3) through the pixels' centres.

        jitter: (height, width, 2) positions within the pixels, 0 to 1, instead of the centres.
        """
        width, height = size
        x, y = np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float))
        shift = np.full((height, width, 2), 0.5) if jitter is None else jitter
        focal = width / 2 / np.tan(self.lens / 2)
        right, up = (x + shift[..., 0] - width / 2) / focal, -(y + shift[..., 1] - height / 2) / focal
        way = right[..., None] * self.axes[0] + up[..., None] * self.axes[1] - self.axes[2]
        return way / np.linalg.norm(way, axis=-1, keepdims=True)

    def project(self, points: np.ndarray, size: tuple[int, int] = SIZE) -> tuple[np.ndarray, np.ndarray]:
        """Return the pixels (..., 2) and depths (...), metres, of points (..., 3)."""
        local = (points - self.position) @ self.axes.T
        depth = -local[..., 2]
        focal = size[0] / 2 / np.tan(self.lens / 2)
        safe = np.maximum(depth, 1e-6)
        x = size[0] / 2 + focal * local[..., 0] / safe
        y = size[1] / 2 - focal * local[..., 1] / safe
        return np.stack([x, y], -1), depth


def looking(position: np.ndarray, target: np.ndarray, lens: float, roll: float = 0.0) -> Camera:
    """Return a camera at a position (3,) that looks at a target (3,); lens and roll in radians."""
    back = (position - target) / np.linalg.norm(position - target)
    right = np.cross([0.0, 1.0, 0.0], back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    c, s = np.cos(roll), np.sin(roll)
    return Camera(np.asarray(position, float), np.stack([c * right + s * up, c * up - s * right, back]), lens)


def draw(
    room: Room, person: np.ndarray, free: np.ndarray, rng: np.random.Generator, tries: int = 30
) -> tuple[Camera, np.ndarray] | None:
    """Return a random camera with points of a person (N, 3) in its picture, and their depths; None if none fits.

    free: (M, 2) unoccupied positions, x and z, metres. Occlusion is left to the caller.
    """
    width, depth, height = room.size
    middle = person.mean(0)
    for _ in range(tries):
        far = np.linalg.norm(free - middle[[0, 2]], axis=-1)
        fits = np.flatnonzero((far > 1.6) & (far < 6.5))
        if not len(fits):
            return None
        # Distant positions show more of the room.
        place = free[rng.choice(fits, p=far[fits] / far[fits].sum())]
        eye = rng.uniform(HEIGHTS[0], min(HEIGHTS[1], height - 0.25))
        position = np.array([place[0], eye, place[1]])
        lens = np.radians(rng.uniform(*LENSES))
        target = middle + rng.normal(0, [0.9, 0.25, 0.9])
        target[1] = np.clip(target[1], 0.4, 1.5)
        camera = looking(position, target, lens, np.radians(rng.normal(0, 1.2)))
        pixels, depths = camera.project(person)
        seen = (depths > 0.5) & ((pixels > 4) & (pixels < np.array(SIZE) - 4)).all(-1)
        if seen.mean() > 0.9:
            return camera, depths
    return None
