"""PointNet without its transform networks (Qi et al. 2017; section 3.2, implementation details).

T-Nets and a normalisation over points are omitted, since both would remove the absolute position that a body needs. The
encoder is pretrained on the segmentation of rooms; each network that uses it fine-tunes its own copy.
"""

from __future__ import annotations

import torch
from torch import nn

from .layout import SCENE

CLASSES = 13
LOCAL = 64


class PointEncoder(nn.Module):
    """Point cloud (B, N, 3) -> feature (B, 256): one network for all points, and a maximum over them."""

    def __init__(self) -> None:
        super().__init__()
        self.local = nn.Sequential(nn.Linear(3, 64), nn.ReLU(), nn.Linear(64, LOCAL), nn.ReLU())
        self.wide = nn.Sequential(nn.Linear(LOCAL, 128), nn.ReLU(), nn.Linear(128, SCENE))

    def forward(self, points: torch.Tensor) -> torch.Tensor:
        return self.wide(self.local(points)).amax(1)

    def features(self, points: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return features of the points (B, N, 64) and of the cloud (B, 256)."""
        local = self.local(points)
        return local, self.wide(local).amax(1)


class PointNet(nn.Module):
    """The encoder with a segmentation head of 13 classes, for the pretraining."""

    def __init__(self) -> None:
        super().__init__()
        self.encoder = PointEncoder()
        self.head = nn.Sequential(
            nn.Linear(LOCAL + SCENE, 256), nn.ReLU(), nn.Linear(256, 128), nn.ReLU(), nn.Linear(128, CLASSES)
        )

    def forward(self, points: torch.Tensor) -> torch.Tensor:
        """Return logits (B, N, 13) of points (B, N, 3)."""
        local, whole = self.encoder.features(points)
        return self.head(torch.cat([local, whole[:, None].expand(-1, points.shape[1], -1)], dim=-1))
