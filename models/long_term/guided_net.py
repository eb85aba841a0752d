"""The core of the shipped RouteNet and PoseNet: residuals to a reference, for windows of any length.

It differs from section 3.3 in three points: the two fully connected layers are applied to each frame instead of to all
frames at once, so that a window may have any length; the output is added to a reference and vanishes at both ends, so
that start and goal are exact; a noise code z makes takes between the same bodies differ.
"""

from __future__ import annotations

import torch
from torch import nn

from .layers import dense, gaussian
from .layout import SCENE
from .point_net import PointEncoder

LATENT = 8
HIDDEN = 192
CODE = 128
STEEPNESS = 8
"""Exponent of the window that is zero at both ends and flat between them."""


def end_window(frames: int, like: torch.Tensor) -> torch.Tensor:
    """Return the factor (T,) of a window's residuals: 0 in the first and the last frame, about 1 between."""
    share = torch.linspace(-1, 1, frames, device=like.device, dtype=like.dtype)
    return 1 - share.abs() ** STEEPNESS


class GuidedNet(nn.Module):
    """Inputs of each frame (B, T, F), of the window (B, S) and a cloud (B, N, 3) -> residuals (B, T, O)."""

    def __init__(self, frame: int, whole: int, outputs: int) -> None:
        super().__init__()
        self.scene = PointEncoder()
        self.whole = dense(whole + SCENE + LATENT, 256, CODE)
        self.lstm = nn.LSTM(frame + CODE, HIDDEN, batch_first=True, bidirectional=True)
        self.head = dense(2 * HIDDEN + CODE, 256, outputs)
        self.each, self.latent = dense(frame + outputs, 128, 128), dense(128, 128, 2 * LATENT)

    def forward(
        self, frames: torch.Tensor, whole: torch.Tensor, cloud: torch.Tensor, z: torch.Tensor
    ) -> torch.Tensor:
        """Return residuals (B, T, O), zero in the first and the last frame. z: (B, 8)."""
        code = self.whole(torch.cat([whole, self.scene(cloud), z], -1))
        spread = code[:, None].expand(-1, frames.shape[1], -1)
        features = self.lstm(torch.cat([frames, spread], -1))[0]
        made = self.head(torch.cat([features, spread], -1))
        return made * end_window(frames.shape[1], frames)[:, None]

    def posterior(self, frames: torch.Tensor, residual: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return mean and log-variance (B, 8) of z for known residuals (B, T, O); for training only."""
        return gaussian(self.latent(self.each(torch.cat([frames, residual], -1)).mean(1)))
