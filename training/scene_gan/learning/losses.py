"""Losses: WGAN-GP with a target of 0.1 (section 4.2), and the inverse Huber loss of the depth (section 3.1)."""

from __future__ import annotations

from collections.abc import Callable

import torch

PENALTY, TARGET = 10.0, 0.1
SHARE = 0.2  # share of the largest error up to which the inverse Huber loss is linear


def gradient_penalty(
    critic: Callable[[torch.Tensor], torch.Tensor],
    real: torch.Tensor,
    made: torch.Tensor,
    share: torch.Tensor,
) -> torch.Tensor:
    """Return the mean of (|gradient| - TARGET)^2 at points between real and made inputs (B, ...).

    share: (B,) weight of the real input in each point.
    """
    share = share.view(-1, *(1 for _ in real.shape[1:]))
    between = (share * real + (1 - share) * made).detach().requires_grad_(True)
    (slope,) = torch.autograd.grad(critic(between).sum(), between, create_graph=True)
    return (slope.flatten(1).norm(dim=1) - TARGET).square().mean()


def inverse_huber(made: torch.Tensor, true: torch.Tensor, known: torch.Tensor) -> torch.Tensor:
    """Return the inverse Huber loss (Laina et al. 2016) of depths where ``known``.

    It is |e| up to c and (e^2 + c^2) / 2c beyond, with c SHARE of the largest error of the batch.
    """
    error = (made - true).abs() * known
    limit = (SHARE * error.max()).detach().clamp(min=1e-3)
    loss = torch.where(error <= limit, error, (error.square() + limit.square()) / (2 * limit))
    return (loss * known).sum() / known.sum().clamp(min=1)
