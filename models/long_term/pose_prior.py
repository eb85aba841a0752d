"""The pose prior: a VAE with 32 numbers for the rotations of 21 body joints, in place of VPoser (section 3.1).

The encoder takes rotation matrices and the decoder returns the 6D form, so that every code is a valid pose. The
decoder is differentiable: sub-goal bodies, PoseNet and the optimisation work on the code.
"""

from __future__ import annotations

import torch
from torch import nn

from .layers import dense, gaussian, sample
from .layout import JOINTS, POSE, matrix_from_six

WIDTH = 512
SMALL = 0.1
"""Share of the usual initial weights of the decoder's last layer."""
IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0)
"""The 6D form of no rotation."""


class PosePrior(nn.Module):
    """Encoder of local rotation matrices (B, 21, 3, 3) -> p (B, 32) and decoder of p -> rotation matrices."""

    def __init__(self, width: int = WIDTH) -> None:
        super().__init__()
        self.encoder = dense(JOINTS * 9, width, width, 2 * POSE)
        self.decoder = dense(POSE, width, width, JOINTS * 6)
        self.begin_at_rest()

    def begin_at_rest(self) -> None:
        """Begin the last layer of the decoder anew, with rotations close to the identity.

        From random ones a joint may be more than a quarter turn away from all captured poses; the loss then has a
        local minimum near a half turn, with the child joint turned back.
        """
        last = self.decoder[-1]
        last.reset_parameters()
        with torch.no_grad():
            last.weight.mul_(SMALL)
            last.bias.copy_(torch.tensor(IDENTITY).repeat(JOINTS))

    def encode(self, rotations: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return mean and log-variance (..., 32) of rotation matrices (..., 21, 3, 3)."""
        return gaussian(self.encoder(rotations.flatten(-3)))

    def decode(self, pose: torch.Tensor) -> torch.Tensor:
        """Return rotation matrices (..., 21, 3, 3) of poses p (..., 32)."""
        return matrix_from_six(self.decoder(pose).unflatten(-1, (JOINTS, 6)))

    def forward(self, rotations: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Return decoded rotation matrices (B, 21, 3, 3), and mean and log-variance (B, 32) of the sampled p."""
        mean, log_variance = self.encode(rotations)
        return self.decode(sample(mean, log_variance)), mean, log_variance
