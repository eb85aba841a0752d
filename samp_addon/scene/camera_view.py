"""What a camera sees of a scene: a small picture with depth. Network frame, metres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

SIZE = (128, 72)
"""Width and height of the pictures that the networks see."""
HIDDEN = 0.3
"""Metres behind the visible surface from which a point is hidden."""


@dataclass(frozen=True)
class CameraView:
    """A picture and its camera.

    name: of the camera. colour: (H, W, 3) uint8. depth: (H, W) metres along the camera's axis, 0 where nothing is.
    lens: (3,) focal length and principal point (x, y) in widths of the picture. extrinsics: (4, 4) from the network
    frame to camera coordinates (x right, y down, z forward).
    """

    name: str
    colour: np.ndarray
    depth: np.ndarray
    lens: np.ndarray
    extrinsics: np.ndarray

    @property
    def eye(self) -> np.ndarray:
        """Place of the camera (3,)."""
        return -self.extrinsics[:3, :3].T @ self.extrinsics[:3, 3]

    @property
    def yaw(self) -> float:
        """Horizontal viewing direction, radians; where the camera looks straight down, that of the picture's top."""
        forward = self.extrinsics[2, :3]
        if np.hypot(forward[0], forward[2]) < 1e-3:
            forward = -self.extrinsics[1, :3]
        return float(np.arctan2(forward[0], forward[2]))

    def project(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return places (..., 2) in widths of the picture, from its upper left corner, and depths (...) in metres."""
        seen = points @ self.extrinsics[:3, :3].T + self.extrinsics[:3, 3]
        ahead = np.maximum(seen[..., 2:], 1e-6)
        return self.lens[0] * seen[..., :2] / ahead + self.lens[1:], seen[..., 2]

    def sees(self, points: np.ndarray, margin: float = 0.0) -> np.ndarray:
        """Return which points (...) of (..., 3) are in the picture and not hidden.

        margin: widths of the picture; points nearer to its edge do not count.
        """
        height, width = self.depth.shape
        place, ahead = self.project(points)
        limits = np.array([1.0, height / width])
        inside = (place > margin).all(-1) & (place < limits - margin).all(-1) & (ahead > 0.1)
        pixel = np.clip((place * width).astype(int), 0, [width - 1, height - 1])
        surface = self.depth[pixel[..., 1], pixel[..., 0]]
        return inside & ((surface == 0) | (ahead < surface + HIDDEN))
