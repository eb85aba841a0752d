"""The trajectory generator, the pose generator (section 3.2, tables 6 and 7), and CSGN, which combines both."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import nn

from . import kinematics, layers
from .joint_graph import LEVELS
from .noise import STEPS, GaussianProcess
from .start import FPS, PELVIS_SPEED, SIZE, Start

FRAMES = 64
ALPHA = (0.1, 0.06, 0.1)
"""Largest velocity of each coordinate (X, Y, Z of the view frame), metres per frame: 3 m/s horizontally. Equation
V = alpha tanh(F)."""
OUTPUTS = 6
NARROWEST = 32
ROUGH_HIDDEN, ROUGH_WAY, ROUGH_POSE = 768, 8, 20
"""Width of the dense networks, and cosines over 64 frames: up to 1.9 Hz for the way, 4.7 Hz for poses."""
SPAN = FRAMES // (STEPS - 2)
"""Frames of a step after the first convolution."""


@dataclass(frozen=True)
class Sizes:
    """Widths of the networks; the narrowest layer of the paper, NARROWEST, is kept.

    scene: size of a scene feature. width: of the widest layer; the others are fractions of it. noise, pose_noise:
    channels of the latents of the two generators.
    """

    scene: int = 256
    width: int = 512
    noise: int = 256
    pose_noise: int = 1024

    def channels(self) -> tuple[int, ...]:
        """Return the channels after each of the five blocks."""
        return tuple(max(self.width // k, min(self.width, NARROWEST)) for k in (1, 2, 4, 8, 16))


def _over_time(noise: torch.Tensor, known: torch.Tensor) -> torch.Tensor:
    """Return inputs (B, C, STEPS): noise, the condition repeated, and the number of the step as a one-hot code.

    The paper has no such code. Without it only the zeros at the ends of convolutions tell the steps apart.
    """
    clock = torch.eye(STEPS, device=noise.device).expand(len(noise), -1, -1)
    return torch.cat([noise, layers.repeated(known, (STEPS,)), clock], dim=1)


def _steps_of(way: torch.Tensor) -> torch.Tensor:
    """Return each latent step's own part of a way (B, 3, FRAMES) as (B, 3 * SPAN, STEPS); the ends are repeated."""
    parts = way.unflatten(-1, (-1, SPAN)).transpose(2, 3).flatten(1, 2)
    return torch.cat([parts[..., :1], parts, parts[..., -1:]], dim=-1)


class _Rough(nn.Module):
    """A dense network whose outputs are cosines over time: the slow part of a window.

    Up-sampling alone learns too slowly: on 64 windows, 160 steps of it leave errors of a frozen pose, and those of this
    network halve them in a quarter of the time. hidden: width. waves: cosines of each output.
    """

    def __init__(self, inputs: int, outputs: int, hidden: int, waves: int) -> None:
        super().__init__()
        self.outputs = outputs
        self.first, self.second = nn.Linear(inputs, hidden), nn.Linear(hidden, hidden)
        self.third, self.last = nn.Linear(hidden, hidden), nn.Linear(hidden, outputs * waves)
        self.last.weight.data *= 0.1  # start near the initial pose
        share = (torch.arange(FRAMES) + 0.5) / FRAMES
        self.register_buffer(
            "cosines", torch.cos(math.pi * torch.arange(waves)[:, None] * share), persistent=False
        )

    def forward(self, *known: torch.Tensor) -> torch.Tensor:
        """Return outputs (B, outputs, 64) of inputs (B, n) each."""
        x = layers.activate(self.first(torch.cat(known, dim=-1)))
        x = x + layers.activate(self.second(x))
        x = x + layers.activate(self.third(x))
        return self.last(x).unflatten(-1, (self.outputs, -1)) @ self.cosines


class TrajectoryGenerator(nn.Module):
    """Noise, scene and start to velocities of the pelvis, 4 -> 8 -> 16 -> 32 -> 64 steps (table 6)."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        widths = sizes.channels()
        self.latent = GaussianProcess(sizes.noise)
        self.first = nn.Conv1d(sizes.noise + sizes.scene + SIZE + STEPS, widths[0], 3)
        self.blocks = nn.ModuleList(
            nn.Conv1d(a, b, 3, padding=1) for a, b in zip(widths[:-1], widths[1:], strict=True)
        )
        self.norms = nn.ModuleList(map(layers.ChannelNorm, widths))
        self.last = nn.Conv1d(widths[-1], 3, 5, padding=2)
        self.rough = _Rough(sizes.noise + sizes.scene + SIZE, 3, ROUGH_HIDDEN, ROUGH_WAY)
        self.register_buffer("alpha", torch.tensor(ALPHA), persistent=False)

    def forward(self, noise: torch.Tensor, scene: torch.Tensor, start: Start) -> torch.Tensor:
        """Return velocities (B, 3, 64), metres per frame. noise: (B, noise, 6). scene: (B, scene)."""
        known = torch.cat([scene, start.condition()], dim=-1)
        x = self.norms[0](self.first(_over_time(noise, known)))
        for block, norm in zip(self.blocks, self.norms[1:], strict=True):
            x = norm(block(layers.twice_as_long(layers.activate(x))))
        raw = self.last(layers.activate(x)) + self.rough(noise.mean(-1), known)
        return self.alpha[:, None] * torch.tanh(raw)


class _GraphUpsampling(nn.Module):
    """The upsampling of table 7: 5 nodes x 4 steps to 22 joints x 64 steps."""

    def __init__(self, inputs: int, sizes: Sizes, outputs: int) -> None:
        super().__init__()
        widths, nodes = sizes.channels(), (LEVELS[2], LEVELS[2], LEVELS[1], LEVELS[1], LEVELS[0])
        # All joints start from the same noise, which a linear map distributes over the five nodes.
        self.nodes = nodes[0]
        self.spread = nn.Conv1d(inputs, widths[0] * nodes[0], 3)
        self.blocks = nn.ModuleList(
            layers.GraphConv(widths[k], widths[k + 1], nodes[k], nodes[k + 1]) for k in range(4)
        )
        self.norms = nn.ModuleList(map(layers.ChannelNorm, widths))
        self.last = layers.GraphConv(widths[-1], outputs, nodes[-1], nodes[-1], kernel=5)
        self.last.over_time.weight.data *= 0.1  # start near the initial pose

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Return outputs (B, outputs, 22, 64) of inputs (B, inputs, 6)."""
        x = self.spread(x).unflatten(1, (-1, self.nodes))
        x = self.norms[0](x)
        for block, norm in zip(self.blocks, self.norms[1:], strict=True):
            x = norm(block(layers.twice_as_long(layers.activate(x))))
        return self.last(layers.activate(x))


def _posed(raw: torch.Tensor, start: Start) -> torch.Tensor:
    """Return rotations (B, 64, 22, 6): the initial pose plus LIMIT tanh of the network's output (B, 6, 22, 64)."""
    change = kinematics.LIMIT * torch.tanh(raw)
    return start.six[:, None] + change.permute(0, 3, 2, 1)


class PoseGenerator(nn.Module):
    """Noise, scene, start and trajectory to 6-D rotations (section 3.2.2, table 7).

    The paper generates joint positions. Here rotations are generated, since they are baked, and the critics use forward
    kinematics. Each step also sees its own part of the trajectory, so that steps of the feet and the way agree.
    """

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        self.latent = GaussianProcess(sizes.pose_noise)
        inputs = sizes.pose_noise + sizes.scene + SIZE + 3 * FRAMES + STEPS + 3 * SPAN
        self.body = _GraphUpsampling(inputs, sizes, OUTPUTS)
        known = sizes.pose_noise + SIZE + 3 * FRAMES
        self.rough = _Rough(known, kinematics.JOINTS * OUTPUTS, ROUGH_HIDDEN, ROUGH_POSE)

    def forward(
        self, noise: torch.Tensor, scene: torch.Tensor, start: Start, velocities: torch.Tensor
    ) -> torch.Tensor:
        """Return rotations (B, 64, 22, 6). velocities: (B, 3, 64), metres per frame."""
        way = velocities * FPS / PELVIS_SPEED
        known = torch.cat([scene, start.condition(), way.flatten(1)], dim=-1)
        x = torch.cat([_over_time(noise, known), _steps_of(way)], dim=1)
        return _posed(self.body(x) + self._slow(noise, start, way), start)

    def roughly(self, noise: torch.Tensor, start: Start, velocities: torch.Tensor) -> torch.Tensor:
        """Return rotations (B, 64, 22, 6) without the up-sampling, which the scene takes part in; see _Rough."""
        return _posed(self._slow(noise, start, velocities * FPS / PELVIS_SPEED), start)

    def _slow(self, noise: torch.Tensor, start: Start, way: torch.Tensor) -> torch.Tensor:
        made = self.rough(noise.mean(-1), start.condition(), way.flatten(1))
        return made.unflatten(1, (kinematics.JOINTS, OUTPUTS)).transpose(1, 2)


class JointGenerator(nn.Module):
    """CSGN: one generator for trajectory and poses (first row of table 1)."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        self.latent = GaussianProcess(sizes.pose_noise)
        self.body = _GraphUpsampling(sizes.pose_noise + sizes.scene + SIZE + STEPS, sizes, OUTPUTS + 3)
        self.register_buffer("alpha", torch.tensor(ALPHA), persistent=False)

    def forward(
        self, noise: torch.Tensor, scene: torch.Tensor, start: Start
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Return velocities (B, 3, 64), from the pelvis' node, metres per frame, and rotations (B, 64, 22, 6)."""
        known = torch.cat([scene, start.condition()], dim=-1)
        raw = self.body(_over_time(noise, known))
        velocities = self.alpha[:, None] * torch.tanh(raw[:, OUTPUTS:, 0])
        return velocities, _posed(raw[:, :OUTPUTS], start)
