"""The shipped RouteNet: the route as a residual to the path around the furniture (equation 1, guided_net.py).

All quantities are in the frame of the window's start, which is at x = z = 0 and faces +Z; heights are unchanged.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import nn

from .guided_net import GuidedNet
from .layers import dense
from .layout import BETAS, PHASE, ROTATION, TRANSLATION, matrix_from_six, yaw_of

PATH = 16
"""Points of a path, evenly spaced along it, both ends included."""

ROUTE = TRANSLATION + ROTATION
FPS = 30.0
_FRAME = (
    ROUTE + 2 + 2
)  # the reference, the direction of the path, the share of time and the remaining seconds
_WHOLE = 2 * ROUTE + BETAS + 2 * PHASE + 2
_DURATION = 9


@dataclass(frozen=True)
class RouteEnds:
    """The conditions of a window's route.

    start, end: (B, 9), t and r. path: (B, 16, 2), x and z. betas: (B, 10). start_gait, end_gait: (B, 2).
    """

    start: torch.Tensor
    end: torch.Tensor
    path: torch.Tensor
    betas: torch.Tensor
    start_gait: torch.Tensor
    end_gait: torch.Tensor

    @property
    def length(self) -> torch.Tensor:
        """Length of the path (B,), metres."""
        return torch.diff(self.path, dim=1).norm(dim=-1).sum(1)


def reference(ends: RouteEnds, frames: int) -> torch.Tensor:
    """Return the route (B, T, 9) at constant speed along the path; height and rotation are interpolated linearly."""
    share = torch.linspace(0, 1, frames, device=ends.path.device, dtype=ends.path.dtype)
    at = share * (PATH - 1)
    low = at.long().clamp(max=PATH - 2)
    part = (at - low)[None, :, None]
    place = ends.path[:, low] * (1 - part) + ends.path[:, low + 1] * part
    rest = ends.start[:, None] + share[None, :, None] * (ends.end - ends.start)[:, None]
    return torch.cat([place[..., :1], rest[..., 1:2], place[..., 1:], rest[..., 3:]], -1)


class GuidedRoute(nn.Module):
    """Ends, path and cloud -> route (B, T, 9), and its usual duration."""

    def __init__(self) -> None:
        super().__init__()
        self.net = GuidedNet(_FRAME, _WHOLE, ROUTE)
        self.seconds_net = dense(_DURATION + 2 * PHASE + BETAS, 64, 64, 1)

    def forward(self, ends: RouteEnds, frames: int, cloud: torch.Tensor, z: torch.Tensor) -> torch.Tensor:
        """Return the route (B, T, 9), whose first and last frames are the ends. cloud: (B, N, 3). z: (B, 8)."""
        steady = reference(ends, frames)
        return steady + self.net(self._frames(ends, steady), self._whole(ends, frames), cloud, z)

    def posterior(self, ends: RouteEnds, route: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return mean and log-variance (B, 8) of z for a known route (B, T, 9)."""
        steady = reference(ends, route.shape[1])
        return self.net.posterior(self._frames(ends, steady), route - steady)

    def seconds(self, ends: RouteEnds) -> torch.Tensor:
        """Return the usual duration (B,) of a window, seconds, from length, turn, heights, gait and body shape."""
        yaws = [yaw_of(matrix_from_six(end[:, 3:])) for end in (ends.start, ends.end)]
        across = ends.end[:, [0, 2]] - ends.start[:, [0, 2]]
        known = [
            ends.length[:, None],
            across.norm(dim=-1, keepdim=True),
            ends.start[:, 1:2],
            ends.end[:, 1:2],
        ]
        known += [f(yaws[1] - yaws[0])[:, None] for f in (torch.cos, torch.sin)]
        known += [(ends.end - ends.start)[:, 1:2].abs(), ends.start[:, 7:8], ends.end[:, 7:8]]
        known += [ends.start_gait, ends.end_gait, ends.betas]
        return torch.exp(self.seconds_net(torch.cat(known, -1))[:, 0].clamp(-3, 3))

    @staticmethod
    def _frames(ends: RouteEnds, steady: torch.Tensor) -> torch.Tensor:
        frames = steady.shape[1]
        ahead = torch.diff(steady[..., [0, 2]], dim=1)
        ahead = torch.cat([ahead, ahead[:, -1:]], 1) * FPS
        share = torch.linspace(0, 1, frames, device=steady.device, dtype=steady.dtype)
        time = torch.stack([share, (1 - share) * frames / FPS], -1)[None].expand(len(steady), -1, -1)
        return torch.cat([steady, ahead, time], -1)

    @staticmethod
    def _whole(ends: RouteEnds, frames: int) -> torch.Tensor:
        seconds = torch.full_like(ends.length[:, None], frames / FPS)
        return torch.cat(
            [ends.start, ends.end, ends.betas, ends.start_gait, ends.end_gait, ends.length[:, None], seconds],
            -1,
        )
