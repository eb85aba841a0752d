"""The shipped PoseNet: poses along a route as a residual to the blend of both ends (equation 2, guided_net.py).

It uses the 6D rotations of the 21 body joints instead of the prior's 32 numbers, whose error (about a centimetre) would
make feet slide; body shape and gait are inputs.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import nn

from .guided_net import GuidedNet
from .guided_route import FPS, ROUTE
from .layout import BETAS, HANDS, JOINTS, PHASE, matrix_from_six

SIX = JOINTS * 6
POSES = SIX + HANDS
_FRAME = ROUTE + 3 + 3 + 3 + PHASE + 2
_WHOLE = 2 * POSES + BETAS + 1


@dataclass(frozen=True)
class PoseEnds:
    """The poses at both ends. start, end: (B, 150), the 6D rotations of 21 joints and h. betas: (B, 10)."""

    start: torch.Tensor
    end: torch.Tensor
    betas: torch.Tensor


def blend(ends: PoseEnds, frames: int) -> torch.Tensor:
    """Return poses (B, T, 150) interpolated linearly from one end to the other."""
    share = torch.linspace(0, 1, frames, device=ends.start.device, dtype=ends.start.dtype)[None, :, None]
    return ends.start[:, None] + share * (ends.end - ends.start)[:, None]


class GuidedPose(nn.Module):
    """Ends, route (B, T, 9), gait (B, T, 2) and cloud -> poses (B, T, 150)."""

    def __init__(self) -> None:
        super().__init__()
        self.net = GuidedNet(_FRAME, _WHOLE, POSES)

    def forward(
        self, ends: PoseEnds, route: torch.Tensor, gait: torch.Tensor, cloud: torch.Tensor, z: torch.Tensor
    ) -> torch.Tensor:
        """Return the poses, of which the first and the last ones are the ends. cloud: (B, N, 3). z: (B, 8)."""
        even = blend(ends, route.shape[1])
        return even + self.net(self._frames(route, gait), self._whole(ends, route), cloud, z)

    def posterior(
        self, ends: PoseEnds, route: torch.Tensor, gait: torch.Tensor, poses: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Return mean and log-variance (B, 8) of z for known poses (B, T, 150)."""
        return self.net.posterior(self._frames(route, gait), poses - blend(ends, route.shape[1]))

    @staticmethod
    def _frames(route: torch.Tensor, gait: torch.Tensor) -> torch.Tensor:
        """Return the inputs of each frame: route, velocity, vertical, remaining displacement, gait and time.

        Velocity, vertical and displacement are in the pelvis' frame.
        """
        frames = route.shape[1]
        pelvis = matrix_from_six(route[..., 3:])
        speed = torch.diff(route[..., :3], dim=1)
        speed = torch.cat([speed, speed[:, -1:]], 1) * FPS
        seen = lambda v: (pelvis.transpose(-1, -2) @ v[..., None])[..., 0]
        up = pelvis[..., 1, :]  # the vertical in the pelvis' frame
        share = torch.linspace(0, 1, frames, device=route.device, dtype=route.dtype)
        time = torch.stack([share, (1 - share) * frames / FPS], -1)[None].expand(len(route), -1, -1)
        left = route[:, -1:, :3] - route[..., :3]
        return torch.cat([route, seen(speed), up, seen(left), gait, time], -1)

    @staticmethod
    def _whole(ends: PoseEnds, route: torch.Tensor) -> torch.Tensor:
        seconds = torch.full_like(ends.betas[:, :1], route.shape[1] / FPS)
        return torch.cat([ends.start, ends.end, ends.betas, seconds], -1)
