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
        links = joint_graph.links(source, target)
        # Channels and joints can be mixed in either order; the smaller intermediate is the faster one.
        self.joints_first = inputs * target <= outputs * source
        self.outputs, kinds = outputs, len(links)
        if self.joints_first:
            rows, self.mix = links.flatten(0, 1), nn.Conv2d(inputs * kinds, outputs, 1, bias=False)
        else:
            rows, self.mix = (
                links.transpose(0, 1).flatten(1),
                nn.Conv2d(inputs, outputs * kinds, 1, bias=False),
            )
        self.register_buffer("links", rows, persistent=False)
        padding = kernel // 2 if padding is None else padding
        self.over_time = nn.Conv2d(outputs, outputs, (1, kernel), padding=(0, padding))

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        batch, channels, _, time = x.shape
        if not self.joints_first:
            mixed = self.mix(x).view(batch * self.outputs, -1, time)
            return self.over_time(self._linked(mixed).view(batch, self.outputs, -1, time))
        linked = self._linked(x.reshape(batch * channels, -1, time))
        # Both convolutions as one: there is no activation between them.
        weight = torch.einsum("oqzk,qczr->oczk", self.over_time.weight, self.mix.weight)
        linked = linked.view(batch, self.mix.in_channels, -1, time)
        return functional.conv2d(linked, weight, self.over_time.bias, padding=self.over_time.padding)

    def _linked(self, x: torch.Tensor) -> torch.Tensor:
        return torch.bmm(self.links.expand(len(x), -1, -1), x)


def activate(x: torch.Tensor) -> torch.Tensor:
    """Apply LeakyReLU, which precedes each convolution."""
    return functional.leaky_relu(x, SLOPE)


def twice_as_long(x: torch.Tensor) -> torch.Tensor:
    """Return values (..., 2 T) of values (..., T), interpolated linearly over time, without aligned corners.

    torch's interpolate does the same, but on a GPU with a single thread for each frame, which is slow.
    """
    before = torch.cat([x[..., :1], x[..., :-1]], dim=-1)
    after = torch.cat([x[..., 1:], x[..., -1:]], dim=-1)
    return torch.stack([0.75 * x + 0.25 * before, 0.75 * x + 0.25 * after], dim=-1).flatten(-2)


def half_as_long(x: torch.Tensor) -> torch.Tensor:
    """Return means of pairs of frames (..., T // 2)."""
    time = x.shape[-1] // 2 * 2
    return x[..., :time].unflatten(-1, (-1, 2)).mean(-1)


def repeated(condition: torch.Tensor, shape: tuple[int, ...]) -> torch.Tensor:
    """Return a condition (B, C) repeated to (B, C, *shape)."""
    return condition.view(*condition.shape, *(1 for _ in shape)).expand(*condition.shape, *shape)
