"""Conversion between Blender's Z-up world and the networks' Y-up frame; nothing else converts between them.

Network frame: metres, Y up, +Z forward, +X to the character's left (SMPL-X's convention).
Blender world: Z up, a character with yaw 0 faces -Y. ``x, y, z`` of the network are ``x, z, -y`` of Blender.
A yaw of 0 faces +Z (Blender's -Y); positive yaw turns left, counter-clockwise seen from above.
"""

from __future__ import annotations

import numpy as np

BLENDER_FROM_NETWORK = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
NETWORK_FROM_BLENDER = BLENDER_FROM_NETWORK.T


def to_network(points: np.ndarray) -> np.ndarray:
    """Convert Blender world vectors (..., 3) to the network frame."""
    return np.asarray(points, dtype=np.float64) @ NETWORK_FROM_BLENDER.T


def to_blender(points: np.ndarray) -> np.ndarray:
    """Convert network-frame vectors (..., 3) to Blender's world."""
    return np.asarray(points, dtype=np.float64) @ BLENDER_FROM_NETWORK.T


def yaw_direction(yaw: np.ndarray | float) -> np.ndarray:
    """Return horizontal unit directions (..., 3) in the network frame for yaws (...) in radians."""
    yaw = np.asarray(yaw, dtype=np.float64)
    return np.stack([np.sin(yaw), np.zeros_like(yaw), np.cos(yaw)], axis=-1)


def yawed_axes(yaw: float) -> np.ndarray:
    """Return the matrix (3, 3) by which row vectors are multiplied to express them in axes turned by a yaw."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])


def ground_lengths(line: np.ndarray) -> np.ndarray:
    """Return the lengths (N,) along a line (N, 3) from its first point to each one, seen from above, metres."""
    steps = np.linalg.norm(np.diff(line[:, [0, 2]], axis=0), axis=-1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def wrap_angle(angle: np.ndarray | float) -> np.ndarray | float:
    """Wrap angles in radians to [-pi, pi)."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def direction_yaw(direction: np.ndarray) -> np.ndarray:
    """Return yaws (...) in radians of network-frame directions (..., 3); their height is ignored."""
    direction = np.asarray(direction)
    return np.arctan2(direction[..., 0], direction[..., 2])
