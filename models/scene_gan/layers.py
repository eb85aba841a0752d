"""Convolutions over time, and over the joints of a body and time (Conv_st of CSGN, tables 7, 8 and 11)."""

from __future__ import annotations

import torch
from torch import nn
from torch.nn import functional

from . import joint_graph

SLOPE = 0.2  # negative slope of LeakyReLU


class ChannelNorm(nn.Module):
    """Normalisation of the channels at each position (B, C, ...) to mean 0 and variance 1, with scale and offset.

    The paper uses batch norm; in a critic it invalidates the per-sample gradient penalty, and in a small generator it
    can make the samples of a batch collapse.
    """

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.scale, self.offset = nn.Parameter(torch.ones(channels)), nn.Parameter(torch.zeros(channels))

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        away = x - x.mean(1, keepdim=True)
        normal = away * torch.rsqrt(away.square().mean(1, keepdim=True) + 1e-5)
        shape = (1, -1) + (1,) * (x.dim() - 2)
        return normal * self.scale.view(shape) + self.offset.view(shape)


class GraphConv(nn.Module):
    """Convolution of (B, C, joints, T) over linked joints, then over time.

    source, target: numbers of joints before and after, levels of joint_graph.py. kernel: frames. padding: zeros on
    both sides of the time axis.
    """

    links: torch.Tensor

    def __init__(
        self, inputs: int, outputs: int, source: int, target: int, kernel: int = 3, padding: int | None = None
    ) -> None:
        super().__init__()
        self.register_buffer("links", joint_graph.links(source, target), persistent=False)
        self.mix = nn.Conv2d(inputs, len(self.links) * outputs, 1, bias=False)
        padding = kernel // 2 if padding is None else padding
        self.over_time = nn.Conv2d(outputs, outputs, (1, kernel), padding=(0, padding))

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        batch, _, joints, time = x.shape
        mixed = self.mix(x).view(batch, len(self.links), -1, joints, time)
        return self.over_time(torch.einsum("bkcjt,kij->bcit", mixed, self.links))


def activate(x: torch.Tensor) -> torch.Tensor:
    """Apply LeakyReLU, which precedes each convolution."""
    return functional.leaky_relu(x, SLOPE)


def twice_as_long(x: torch.Tensor) -> torch.Tensor:
    """Return values (..., 2 T) of values (..., T), interpolated linearly over time."""
    if x.dim() == 3:
        return functional.interpolate(x, scale_factor=2, mode="linear", align_corners=False)
    batch, channels, joints, time = x.shape
    longer = functional.interpolate(
        x.reshape(batch, channels * joints, time), scale_factor=2, mode="linear", align_corners=False
    )
    return longer.view(batch, channels, joints, 2 * time)


def half_as_long(x: torch.Tensor) -> torch.Tensor:
    """Return means of pairs of frames (..., T // 2)."""
    time = x.shape[-1] // 2 * 2
    return x[..., :time].unflatten(-1, (-1, 2)).mean(-1)


def repeated(condition: torch.Tensor, shape: tuple[int, ...]) -> torch.Tensor:
    """Return a condition (B, C) repeated to (B, C, *shape)."""
    return condition.view(*condition.shape, *(1 for _ in shape)).expand(*condition.shape, *shape)
