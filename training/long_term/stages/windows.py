"""Common parts of the training of routes and poses: length of a batch, ends, planned gait."""

from __future__ import annotations

import torch

from ....models.long_term import gait, layout
from ....models.long_term.guided_pose import PoseEnds
from ....models.long_term.guided_route import RouteEnds
from ..data import LongTermData, Windows

POINTS = 512
RADIUS = 2.0
PRIOR_SHARE = 0.1  # share of the windows whose noise is drawn from the prior instead of the posterior
FREE = 0.2  # nats of the divergence of each number of the noise that cost nothing


def draw_length(data: LongTermData) -> int:
    """Return a length of windows, drawn uniformly."""
    lengths = sorted(data.rows)
    return lengths[int(torch.randint(len(lengths), ()))]


def route_ends(windows: Windows) -> RouteEnds:
    """Return the conditions of the windows' routes."""
    return RouteEnds(
        windows.route[:, 0], windows.route[:, -1], windows.path, windows.betas, windows.gait[:, 0],
        windows.gait[:, -1],
    )  # fmt: skip


def poses(windows: Windows) -> torch.Tensor:
    """Return the 6D rotations and hands (B, T, 150)."""
    return torch.cat([layout.six_from_matrix(windows.turns).flatten(-2), windows.hands], -1)


def pose_ends(windows: Windows) -> PoseEnds:
    """Return the poses of both ends."""
    known = poses(windows)
    return PoseEnds(known[:, 0], known[:, -1], windows.betas)


def planned_gait(windows: Windows, route: torch.Tensor) -> torch.Tensor:
    """Return the gait (B, T, 2) along a route as planned at inference, with the true number of strides."""
    first, last = (torch.atan2(windows.gait[:, k, 1], windows.gait[:, k, 0]) for k in (0, -1))
    turn = torch.remainder(last - first, 2 * torch.pi)
    strides = torch.round((windows.total - turn) / (2 * torch.pi)).clamp(min=0)
    return gait.planned(windows.gait[:, 0], turn + 2 * torch.pi * strides, route)
