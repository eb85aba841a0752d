"""Bodies at sub-goals: the conditional VAE of section 3.2, figure 3 (a).

All quantities are in the sub-goal's own frame. The given {beta, t, r} contain an approximate position and orientation
of the pelvis, also for lying bodies; the network predicts the residual to them. The paper's condition has neither gait
nor action. Here the gait's two numbers describe standing still (0, 0) or an instant of a stride; the action is one of
three, or none (zeros).

An artist specifies a facing, not r, so the weights include a table of captured orientations for each action.
"""

from __future__ import annotations

import torch
from torch import nn

from .layers import ResidualBlock, dense, gaussian, sample
from .layout import BETAS, BODY, PHASE, ROTATION, SCENE, TRANSLATION
from .point_net import PointEncoder

LATENT = 32
WIDTH = 256
ACTIONS = ("idle", "sit", "lie")
TURNS = 128
"""Number of captured bodies of each action in the table."""
_GIVEN = TRANSLATION + ROTATION


class SubGoalNet(nn.Module):
    """Encoder (body, condition) -> z (B, 32) and decoder (z, condition) -> body (B, 65)."""

    def __init__(self, width: int = WIDTH) -> None:
        super().__init__()
        self.scene = PointEncoder()
        self.integrated = nn.Linear(SCENE + BETAS + _GIVEN + PHASE + len(ACTIONS), width)
        self.body = nn.Sequential(nn.Linear(BODY + BETAS, width), ResidualBlock(width), ResidualBlock(width))
        self.latent = dense(2 * width, width, 2 * LATENT)
        self.decoder = nn.Sequential(
            nn.Linear(LATENT + width, width), ResidualBlock(width), ResidualBlock(width), nn.LeakyReLU(0.2),
            nn.Linear(width, BODY),
        )  # fmt: skip
        upright = torch.tensor([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0])
        self.register_buffer("turns", upright.repeat(len(ACTIONS), TURNS, 1))

    def given(self, action: str, heights: torch.Tensor, rows: torch.Tensor) -> torch.Tensor:
        """Return t and r (B, 9) of captured bodies at a place.

        action: one of ACTIONS. heights: (B,) of the pelvis over the floor, metres. rows: (B,) of the table, which
        contains r of bodies that face +Z, and the pelvis' height over its support relative to the median.
        """
        known = self.turns[ACTIONS.index(action), rows]
        zero = torch.zeros_like(heights)
        return torch.cat([torch.stack([zero, heights + known[:, -1], zero], -1), known[:, :-1]], -1)

    def condition(
        self,
        cloud: torch.Tensor,
        betas: torch.Tensor,
        given: torch.Tensor,
        gait: torch.Tensor,
        action: torch.Tensor,
    ) -> torch.Tensor:
        """Return the integrated feature F^hs (B, W).

        cloud: (B, N, 3). betas: (B, 10). given: (B, 9), t and r. gait: (B, 2), see gait.py. action: (B, 3) of ACTIONS,
        one of them 1, or zeros.
        """
        joined = torch.cat([self.scene(cloud), betas, given, gait, action], dim=-1)
        return nn.functional.leaky_relu(self.integrated(joined), 0.2)

    def encode(
        self, condition: torch.Tensor, body: torch.Tensor, betas: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Return mean and log-variance (B, 32) of z for bodies (B, 65)."""
        return gaussian(self.latent(torch.cat([self.body(torch.cat([body, betas], -1)), condition], dim=-1)))

    def decode(self, condition: torch.Tensor, given: torch.Tensor, z: torch.Tensor) -> torch.Tensor:
        """Return bodies (B, 65); t and r are residuals to the given ones."""
        made = self.decoder(torch.cat([z, condition], dim=-1))
        return torch.cat([made[..., :_GIVEN] + given, made[..., _GIVEN:]], dim=-1)

    def forward(
        self,
        cloud: torch.Tensor,
        betas: torch.Tensor,
        given: torch.Tensor,
        gait: torch.Tensor,
        action: torch.Tensor,
        body: torch.Tensor,
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Return reconstructed bodies (B, 65), and mean and log-variance (B, 32) of the sampled z."""
        condition = self.condition(cloud, betas, given, gait, action)
        mean, log_variance = self.encode(condition, body, betas)
        return self.decode(condition, given, sample(mean, log_variance)), mean, log_variance
