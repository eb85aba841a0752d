"""Losses: WGAN-GP with a target of 0.1 (section 4.2), the inverse Huber loss of the depth (section 3.1), and the
error of the nearest of several draws."""

from __future__ import annotations

from collections.abc import Callable

import torch

from ....models.scene_gan.projection import Motions

PENALTY, TARGET = 10.0, 0.1
SPEED = 10.0  # frames: weight of errors of velocity, metres per frame, beside those of position, metres
TURN = 1.0  # metres: weight of errors of the 6-D rotations; with 0.2, joints turned once about their bones
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


def nearest_of(made: Motions, true: Motions, draws: int, part: str) -> torch.Tensor:
    """Return the mean error of the nearest of several draws of each window (the variety loss of Gupta et al. 2018).

    made: draws * B windows, those of one start in a row. true: B windows. part: trained, of options.PARTS; for the
    trajectory alone, only the pelvis counts. The errors are of positions, velocities (which keeps standing feet still)
    and rotations.
    """
    rows = torch.arange(len(true.root), device=true.root.device).repeat_interleave(draws)
    true = true.rows(rows)
    if part == "trajectory":
        apart = made.root - true.root
        error = apart.norm(dim=-1).mean(1) + SPEED * (apart[:, 1:] - apart[:, :-1]).norm(dim=-1).mean(1)
    else:
        apart = made.joints - true.joints
        error = apart.norm(dim=-1).mean((1, 2)) + TURN * (made.six - true.six).abs().mean((1, 2, 3))
        error = error + SPEED * (apart[:, 1:] - apart[:, :-1]).norm(dim=-1).mean((1, 2))
    return error.view(-1, draws).min(1).values.mean()
