"""Latent sequences from a Gaussian process over time, one length scale for each channel (section 3.2.1)."""

from __future__ import annotations

import torch
from torch import nn

STEPS = 6
"""Length of the latent sequence; the first convolution, without padding, leaves 4 steps (tables 6 and 7)."""
SHORTEST, LONGEST = 0.4, 4.0
"""Length scales of the first and the last channel, in steps; the paper does not specify them."""


class GaussianProcess(nn.Module):
    """Sequences (B, channels, STEPS) with the covariance exp(-|t1 - t2| / (2 sigma_c^2)) in channel c."""

    factor: torch.Tensor

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.channels = channels
        sigma = torch.logspace(
            torch.log10(torch.tensor(SHORTEST)), torch.log10(torch.tensor(LONGEST)), channels
        )
        time = torch.arange(STEPS, dtype=torch.float32)
        apart = (time[:, None] - time).abs()
        covariance = torch.exp(-apart / (2 * sigma[:, None, None] ** 2)) + 1e-5 * torch.eye(STEPS)
        self.register_buffer("factor", torch.linalg.cholesky(covariance), persistent=False)

    def draw(self, count: int, generator: torch.Generator | None = None) -> torch.Tensor:
        """Draw ``count`` sequences. generator: on the CPU, so that a seed gives the same draw on every device."""
        white = torch.randn(
            count, self.channels, STEPS, 1, generator=generator, device=_device(self, generator)
        )
        return (self.factor @ white.to(self.factor.device))[..., 0]


def _device(module: GaussianProcess, generator: torch.Generator | None) -> torch.device:
    return module.factor.device if generator is None else generator.device
