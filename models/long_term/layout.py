"""The numbers that describe a body, M = (t, r, beta, p, h) of section 3.1, and rotations in 6D form.

Network frame: metres, Y up, +Z forward. Unless stated otherwise, bodies are expressed in the frame of a place, with its
x and z as origin and its facing as +Z; heights are unchanged.
"""

from __future__ import annotations

import torch

TRANSLATION, ROTATION, BETAS, POSE, HANDS = 3, 6, 10, 32, 24
JOINTS = 21
"""Body joints without the pelvis; the pose prior encodes their local rotations."""

BODY = TRANSLATION + ROTATION + POSE + HANDS
"""Numbers of a body without its shape, in the order t, r, p, h."""

SCENE = 256
"""Size of the feature of a point cloud."""

FRAMES = 61
"""Frames of a window of the paper, both ends included: two seconds."""

PHASE = 2
"""Amplitude times cosine and sine of the gait's phase, see gait.py."""

Parts = tuple[torch.Tensor, torch.Tensor, torch.Tensor, torch.Tensor]


def split_body(body: torch.Tensor) -> Parts:
    """Return t (..., 3), r (..., 6), p (..., 32) and h (..., 24) of bodies (..., 65)."""
    return body.split([TRANSLATION, ROTATION, POSE, HANDS], dim=-1)


def matrix_from_six(six: torch.Tensor) -> torch.Tensor:
    """Return rotation matrices (..., 3, 3) of the 6D form (..., 6), which need not be orthonormal (Zhou et al. 2019).

    The six numbers are the first two columns of the matrix.
    """
    first = torch.nn.functional.normalize(six[..., :3], dim=-1)
    second = six[..., 3:] - (first * six[..., 3:]).sum(-1, keepdim=True) * first
    second = torch.nn.functional.normalize(second, dim=-1)
    return torch.stack([first, second, torch.cross(first, second, dim=-1)], dim=-1)


def six_from_matrix(matrix: torch.Tensor) -> torch.Tensor:
    """Return the 6D form (..., 6) of rotation matrices (..., 3, 3)."""
    return torch.cat([matrix[..., 0], matrix[..., 1]], dim=-1)


def about_y(yaw: torch.Tensor) -> torch.Tensor:
    """Return rotation matrices (..., 3, 3) about the vertical axis; yaw (...) in radians, 0 faces +Z."""
    cos, sin, zero, one = torch.cos(yaw), torch.sin(yaw), torch.zeros_like(yaw), torch.ones_like(yaw)
    rows = [[cos, zero, sin], [zero, one, zero], [-sin, zero, cos]]
    return torch.stack([torch.stack(row, -1) for row in rows], -2)


def yaw_of(matrix: torch.Tensor) -> torch.Tensor:
    """Return the yaw (...) of root rotations (..., 3, 3): the facing perpendicular to the pelvis' left, +X.

    Defined for standing, seated and lying bodies alike; undefined only for a body on its side.
    """
    return torch.atan2(-matrix[..., 2, 0], matrix[..., 0, 0])


def lying_yaw_of(matrix: torch.Tensor) -> torch.Tensor:
    """Return the yaw (...) of root rotations (..., 3, 3) of lying bodies: from the head to the feet.

    Equal to `yaw_of` for a supine body; also defined for one on its side or prone.
    """
    return torch.atan2(-matrix[..., 0, 1], -matrix[..., 2, 1])
