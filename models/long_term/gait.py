"""The phase of the gait, estimated from a single pose, and its course along a route.

The phase is 0 when the left foot is farthest ahead and pi when the right one is. In between, the other foot swings and
is higher. The ankles' distance ahead and their difference in height, each relative to its usual range, therefore
approximate the cosine and sine of the phase; their norm is the amplitude, near 0 while standing and near 1 in brisk
walking.
"""

from __future__ import annotations

import torch

STRIDE, LIFT = 0.30, 0.10
"""Usual largest distance of the ankles along the facing, and in height, metres."""

LEFT_ANKLE, RIGHT_ANKLE = 7, 8
STRIDE_LENGTH = 1.15
"""Length of a whole cycle, two steps, at the usual pace indoors, metres."""

WALKING = 0.4
"""Speed at which the amplitude of a planned gait is about two thirds, metres per second."""


def phase_of(joints: torch.Tensor, yaw: torch.Tensor) -> torch.Tensor:
    """Return amplitude times cosine and sine of the phase (..., 2), of poses.

    joints: (..., J, 3) in the order of SMPL-X, metres. yaw: (...) facing, radians.
    """
    across = joints[..., LEFT_ANKLE, :] - joints[..., RIGHT_ANKLE, :]
    ahead = across[..., 0] * torch.sin(yaw) + across[..., 2] * torch.cos(yaw)
    return torch.stack([ahead / STRIDE, -across[..., 1] / LIFT], -1).clamp(-2, 2)


def unwrapped(gait: torch.Tensor) -> torch.Tensor:
    """Return the phase (B, T) in radians without jumps, of gaits (B, T, 2)."""
    angle = torch.atan2(gait[..., 1], gait[..., 0])
    step = torch.diff(angle, dim=-1)
    step = torch.remainder(step + torch.pi, 2 * torch.pi) - torch.pi
    return torch.cat([angle[..., :1], angle[..., :1] + step.cumsum(-1)], -1)


def advance(start: torch.Tensor, end: torch.Tensor, length: torch.Tensor) -> torch.Tensor:
    """Return the advance of the phase from one end to the other (B,), radians, at strides of usual length.

    start, end: gaits (B, 2). length: of the route (B,), metres. The advance is never negative.
    """
    first, last = (torch.atan2(gait[..., 1], gait[..., 0]) for gait in (start, end))
    turn = torch.remainder(last - first, 2 * torch.pi)
    usual = 2 * torch.pi * length / STRIDE_LENGTH
    return turn + 2 * torch.pi * torch.round((usual - turn) / (2 * torch.pi)).clamp(min=0)


def planned(start: torch.Tensor, total: torch.Tensor, route: torch.Tensor, fps: float = 30.0) -> torch.Tensor:
    """Return the gait (B, T, 2) along a route: the phase advances with the distance, the amplitude follows the speed.

    start: gait (B, 2) of the first frame. total: radians (B,). route: positions (B, T, 3), metres.
    """
    steps = torch.diff(route[..., [0, 2]], dim=1).norm(dim=-1)
    way = torch.cat([torch.zeros_like(steps[:, :1]), steps.cumsum(1)], 1)
    share = way / way[:, -1:].clamp(min=1e-3)
    phase = torch.atan2(start[..., 1], start[..., 0])[:, None] + share * total[:, None]
    speed = torch.cat([steps, steps[:, -1:]], 1) * fps
    size = 1 - torch.exp(-(speed / WALKING).square())
    return size[..., None] * torch.stack([torch.cos(phase), torch.sin(phase)], -1)
