"""Rotations in 6-D form and forward kinematics of the 22 body joints, differentiable."""

from __future__ import annotations

import torch
from torch.nn import functional

from . import constants

JOINTS = 22
PARENTS = (-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19)
LEVELS = (
    (1, 2, 3), (4, 5, 6), (7, 8, 9), (10, 11, 12, 13, 14), (15, 16, 17), (18, 19), (20, 21),
)  # fmt: skip
"""Joints by their depth in the hierarchy, without the pelvis."""
LIMIT = 2.0
"""Largest magnitude of a generated 6-D number relative to the initial pose: from -1 to 1."""


def matrices(six: torch.Tensor) -> torch.Tensor:
    """Return rotation matrices (..., 3, 3) of 6-D numbers (..., 6), their first two columns before Gram-Schmidt."""
    first = functional.normalize(six[..., :3], dim=-1, eps=1e-6)
    second = six[..., 3:] - (first * six[..., 3:]).sum(-1, keepdim=True) * first
    second = functional.normalize(second, dim=-1, eps=1e-6)
    return torch.stack([first, second, torch.cross(first, second, dim=-1)], dim=-1)


def six_numbers(rotations: torch.Tensor) -> torch.Tensor:
    """Return the 6-D form (..., 6) of rotation matrices (..., 3, 3)."""
    return torch.cat([rotations[..., 0], rotations[..., 1]], dim=-1)


def quaternion_matrices(quats: torch.Tensor) -> torch.Tensor:
    """Return rotation matrices (..., 3, 3) of unit quaternions w, x, y, z (..., 4)."""
    w, x, y, z = quats.unbind(-1)
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
    return torch.stack([torch.stack(row, -1) for row in rows], -2)


def joint_positions(rotations: torch.Tensor, rest: torch.Tensor) -> torch.Tensor:
    """Return joint positions (..., 22, 3) relative to the pelvis.

    rotations: (..., 22, 3, 3) relative to the parent; the pelvis' in the view frame. rest: (..., 22, 3) rest joints,
    broadcast over the leading dimensions.
    """
    order = [0, *(joint for level in LEVELS for joint in level)]
    turned, places = [rotations[..., :1, :, :]], [torch.zeros_like(rotations[..., :1, :, 0])]
    pick = lambda values, rows, axis: values.index_select(
        axis, constants.indices(tuple(rows), rotations.device)
    )
    bones = rest[..., 1:, :] - pick(rest, PARENTS[1:], -2)
    before = [0]
    for level in LEVELS:
        # All joints of the same depth at once, to minimise the number of operations on a GPU.
        at = [before.index(PARENTS[joint]) for joint in level]
        parents = pick(turned[-1], at, -3)
        bone = pick(bones, (joint - 1 for joint in level), -2)[..., None]
        places.append(pick(places[-1], at, -2) + (parents @ bone)[..., 0])
        turned.append(parents @ pick(rotations, level, -3))
        before = list(level)
    return pick(torch.cat(places, dim=-2), (order.index(joint) for joint in range(JOINTS)), -2)
