"""Layers shared by several networks."""

from __future__ import annotations

import torch
from torch import nn

LOG_VARIANCE = (-12.0, 6.0)


class ResidualBlock(nn.Module):
    """Two fully connected layers whose output is added to their input (section 3.2)."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.first, self.second = nn.Linear(width, width), nn.Linear(width, width)

    def forward(self, values: torch.Tensor) -> torch.Tensor:
        return values + self.second(_active(self.first(_active(values))))


def _active(values: torch.Tensor) -> torch.Tensor:
    return nn.functional.leaky_relu(values, 0.2)


def dense(*sizes: int) -> nn.Sequential:
    """Return fully connected layers with a leaky ReLU between them."""
    stack: list[nn.Module] = []
    for inputs, outputs in zip(sizes[:-1], sizes[1:], strict=True):
        stack += [nn.Linear(inputs, outputs), nn.LeakyReLU(0.2)]
    return nn.Sequential(*stack[:-1])


def gaussian(values: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Return mean and log-variance (..., Z) of a layer's output (..., 2 Z)."""
    mean, log_variance = values.chunk(2, dim=-1)
    return mean, log_variance.clamp(*LOG_VARIANCE)


def sample(mean: torch.Tensor, log_variance: torch.Tensor) -> torch.Tensor:
    """Draw from a Gaussian, with gradients to mean and log-variance."""
    return mean + torch.randn_like(mean) * torch.exp(0.5 * log_variance)


def divergence(mean: torch.Tensor, log_variance: torch.Tensor, free: float = 0.0) -> torch.Tensor:
    """Return the Kullback-Leibler divergence from a standard Gaussian, summed over the code, mean over the batch.

    free: nats that each number of the code may hold at no cost, so that the code is used (Kingma et al. 2016).
    """
    each = 0.5 * (mean.square() + log_variance.exp() - 1 - log_variance)
    return each.flatten(0, -2).mean(0).clamp(min=free).sum()
