"""The four discriminators (section 3.3, tables 8 to 11): WGAN critics, without batch norm, with a score per sample.

A condition that the paper repeats and concatenates is added, by a linear map, after the first convolution: equivalent
except at the borders, at a fraction of the cost.
"""

from __future__ import annotations

import torch
from torch import nn

from . import layers, projection
from .generators import ALPHA, Sizes
from .joint_graph import LEVELS
from .projection import Motions
from .start import SIZE, Start

POSE_CHANNELS = 3 + 6 + 3


def _widths(sizes: Sizes) -> tuple[int, ...]:
    """Return the channels after each of the five blocks (tables 8, 10 and 11)."""
    whole = sizes.width
    return tuple(max(whole // k, 8) for k in (8, 8, 4, 2, 1))


class TrajectoryCritic(nn.Module):
    """A critic of velocities with scene and start (table 10)."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        widths = _widths(sizes)
        self.known = nn.Linear(sizes.scene + SIZE, widths[0])
        self.first = nn.Conv1d(3, widths[0], 5, padding=2)
        self.blocks = nn.ModuleList(
            nn.Conv1d(a, b, 3, padding=1) for a, b in zip(widths[:-1], widths[1:], strict=True)
        )
        self.last = nn.Linear(widths[-1], 1)
        self.register_buffer("alpha", torch.tensor(ALPHA), persistent=False)

    def inputs(self, motions: Motions, start: Start) -> torch.Tensor:
        """Return the inputs (B, 3, 64): velocities relative to the largest ones."""
        return motions.velocities / self.alpha[:, None]

    def forward(self, inputs: torch.Tensor, scene: torch.Tensor, start: Start) -> torch.Tensor:
        """Return scores (B,)."""
        known = self.known(torch.cat([scene, start.condition()], dim=-1))
        x = self.first(inputs) + known[..., None]
        for block in self.blocks:
            x = layers.half_as_long(block(layers.activate(x)))
        return self.last(layers.activate(x).mean(-1))[:, 0]


class _GraphCritic(nn.Module):
    """A critic of 22 joints x 65 frames, with the scene as a condition (tables 8 and 11)."""

    def __init__(self, inputs: int, sizes: Sizes) -> None:
        super().__init__()
        widths = _widths(sizes)
        nodes = (LEVELS[0], LEVELS[1], LEVELS[1], LEVELS[2], LEVELS[2], LEVELS[3])
        self.known = nn.Linear(sizes.scene, widths[0])
        self.first = layers.GraphConv(inputs, widths[0], nodes[0], nodes[1])
        self.blocks = nn.ModuleList(
            layers.GraphConv(widths[k], widths[k + 1], nodes[k + 1], nodes[k + 2]) for k in range(4)
        )
        self.last = nn.Linear(widths[-1], 1)

    def forward(self, inputs: torch.Tensor, scene: torch.Tensor, start: Start) -> torch.Tensor:
        """Return scores (B,) of inputs (B, C, 22, 65)."""
        x = self.first(inputs) + self.known(scene)[..., None, None]
        for block in self.blocks:
            x = layers.half_as_long(block(layers.activate(x)))
        return self.last(layers.activate(x).mean((-1, -2)))[:, 0]


class PoseCritic(_GraphCritic):
    """A critic of poses along the trajectory: joint positions and rotations, velocity of the pelvis (table 11)."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__(POSE_CHANNELS, sizes)
        self.register_buffer("alpha", torch.tensor(ALPHA), persistent=False)

    def inputs(self, motions: Motions, start: Start) -> torch.Tensor:
        """Return the inputs (B, 12, 22, 65)."""
        before = torch.cat([start.root_velocity[..., None], motions.velocities], dim=-1)
        way = (before / self.alpha[:, None])[:, :, None].expand(-1, -1, motions.six.shape[2], -1)
        body = torch.cat([2 * motions.positions, motions.six], dim=-1).permute(0, 3, 2, 1)
        return torch.cat([body, way], dim=1)


class ProjectionCritic(_GraphCritic):
    """A critic of the motion in the picture (section 3.3.1, table 8)."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__(2, sizes)

    def inputs(self, motions: Motions, start: Start) -> torch.Tensor:
        """Return the inputs (B, 2, 22, 65): positions of the joints, 0 at the picture's centre, 1 at its right edge."""
        return (2 * projection.project(motions.joints, start) - 1).clamp(-4, 4).permute(0, 3, 2, 1)


class ContextCritic(nn.Module):
    """A critic of crops of relative depth along the trajectory (section 3.3.2, table 9)."""

    def __init__(self, sizes: Sizes, crop: tuple[int, int] = (36, 64)) -> None:
        super().__init__()
        self.crop = crop
        widths = (9, *(max(sizes.width // k, 8) for k in (8, 4, 2)))
        self.blocks = nn.ModuleList(
            nn.Conv2d(a, b, 3, stride=2, padding=1) for a, b in zip(widths[:-1], widths[1:], strict=True)
        )
        self.last = nn.Linear(widths[-1], 1)

    def inputs(self, motions: Motions, start: Start, depth: torch.Tensor) -> torch.Tensor:
        """Return the inputs (B, 9, H, W). depth: (B, 1, H, W) metres."""
        return projection.relative_depth(motions, start, depth, self.crop)

    def forward(self, inputs: torch.Tensor, scene: torch.Tensor, start: Start) -> torch.Tensor:
        """Return scores (B,)."""
        x = inputs
        for number, block in enumerate(self.blocks):
            x = block(layers.activate(x) if number else x)
        return self.last(layers.activate(x).mean((-1, -2)))[:, 0]
