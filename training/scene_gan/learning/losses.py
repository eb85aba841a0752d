"""Losses: WGAN-GP with a target of 0.1 (section 4.2), the inverse Huber loss of the depth (section 3.1), and the
error of the nearest of several draws."""

from __future__ import annotations

from collections.abc import Callable

import torch

from ....models.scene_gan.projection import Motions
from ....models.scene_gan.start import FPS

PENALTY, TARGET = 10.0, 0.1
SPEED = 10.0  # frames: weight of errors of velocity, metres per frame, beside those of position, metres
TURN = 1.0  # metres: weight of errors of the 6-D rotations; with 0.2, joints turned once about their bones
WINDOWS = (16, 32, 64)  # frames of the spectra
BEGINNING = (
    8  # frames in which velocities are compared directly beside spectra: the start has the phase of the gait
)
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


def spectral_error(made: torch.Tensor, true: torch.Tensor) -> torch.Tensor:
    """Return the mean difference (B,) of the amplitudes of signals (B, C, T) in octaves of frequency, summed over them.

    It ignores phase, and frequency within an octave. A mean error prefers no steps to steps out of phase, and an error
    of single frequencies prefers none to steps at another pace.
    """
    error = torch.zeros(len(made), device=made.device)
    for size in WINDOWS:
        apart = (_amplitudes(made, size) - _amplitudes(true, size)).abs().sum(1).mean(-1)
        error = error + apart.view(len(made), -1).mean(1) / len(WINDOWS)
    return error


def _amplitudes(signals: torch.Tensor, size: int) -> torch.Tensor:
    """Return amplitudes (B C, octaves, n) in windows of a size, of signals (B, C, T); the first octave is the mean."""
    window = torch.hann_window(size, device=signals.device)
    found = torch.stft(
        signals.flatten(0, 1), size, size // 4, window=window, center=False, return_complex=True
    )
    power = torch.view_as_real(found).square().sum(-1)
    octaves = [1, *(2**k for k in range(size.bit_length() - 2))]
    octaves[-1] += 1  # the last line
    together = torch.stack([part.sum(1) for part in power.split(octaves, dim=1)], 1)
    return (together + 1e-10).sqrt() * (2 / window.sum())


def nearest_of(made: Motions, true: Motions, draws: int, part: str, spectral: float = 0.0) -> torch.Tensor:
    """Return the mean error of the nearest of several draws of each window (the variety loss of Gupta et al. 2018).

    made: draws * B windows, those of one start in a row. true: B windows. part: trained, of options.PARTS; for the
    trajectory alone, only the pelvis counts. The errors are of positions, velocities (which keeps standing feet still)
    and rotations. spectral: weight of `spectral_error` of the joints' velocities, m/s; with it, velocities of a
    trajectory are compared directly in the first frames only.
    """
    rows = torch.arange(len(true.root), device=true.root.device).repeat_interleave(draws)
    true = true.rows(rows)
    places = lambda each: each.root[:, :, None] if part == "trajectory" else each.joints
    apart = places(made) - places(true)
    speeds = apart.diff(dim=1)
    error = apart.norm(dim=-1).mean((1, 2))
    if part != "trajectory":
        error = error + TURN * (made.six - true.six).abs().mean((1, 2, 3))
    elif spectral:
        speeds = speeds[:, :BEGINNING]
    error = error + SPEED * speeds.norm(dim=-1).mean((1, 2))
    if spectral:
        error = error + spectral * spectral_error(_moves(places(made)), _moves(places(true)))
    return error.view(-1, draws).min(1).values.mean()


def _moves(places: torch.Tensor) -> torch.Tensor:
    """Return the velocities (B, 3 J, T - 1), metres per second, of joints (B, T, J, 3)."""
    return FPS * places.diff(dim=1).flatten(2).transpose(1, 2)
