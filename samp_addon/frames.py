"""The one place that turns Blender's Z-up world into the networks' Y-up frame, and back.

Network frame: metres, Y up, +Z forward, +X to the character's left (SMPL-X's convention).
Blender world: Z up, a character with yaw 0 faces -Y. ``x, y, z`` of the network are ``x, z, -y`` of Blender.
A yaw of 0 faces +Z (Blender's -Y); positive yaw turns left, counter-clockwise seen from above.
"""

from __future__ import annotations

import numpy as np

BLENDER_FROM_NETWORK = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
NETWORK_FROM_BLENDER = BLENDER_FROM_NETWORK.T


def to_network(points: np.ndarray) -> np.ndarray:
    """Blender world vectors (..., 3) to the network frame."""
    return np.asarray(points, dtype=np.float64) @ NETWORK_FROM_BLENDER.T


def to_blender(points: np.ndarray) -> np.ndarray:
    """Network-frame vectors (..., 3) to Blender's world."""
    return np.asarray(points, dtype=np.float64) @ BLENDER_FROM_NETWORK.T


def yaw_direction(yaw: np.ndarray | float) -> np.ndarray:
    """Horizontal facing (..., 3) in the network frame of a yaw in radians."""
    yaw = np.asarray(yaw, dtype=np.float64)
    return np.stack([np.sin(yaw), np.zeros_like(yaw), np.cos(yaw)], axis=-1)


def wrapped(angle: np.ndarray | float) -> np.ndarray | float:
    """The same angles in radians between minus pi and pi."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def direction_yaw(direction: np.ndarray) -> np.ndarray:
    """Yaw in radians of network-frame directions (..., 3); the height component is ignored."""
    direction = np.asarray(direction)
    return np.arctan2(direction[..., 0], direction[..., 2])
