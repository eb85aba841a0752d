"""A classifier of captured and generated windows, in place of the user study of the paper's table 3.

Its accuracy on windows of other rooms is 0.5 where they are indistinguishable, and 1 where they always differ.
"""

from __future__ import annotations

import numpy as np
import torch
from torch import nn

CHANNELS = 64
STEPS, BATCH, RATE = 400, 64, 1e-3
HELD = 0.3  # share of the rooms on which the accuracy is measured


class _Judge(nn.Module):
    """Convolutions over time of joints relative to the pelvis and of their velocities."""

    def __init__(self, joints: int) -> None:
        super().__init__()
        self.layers = nn.Sequential(
            nn.Conv1d(6 * joints, CHANNELS, 5, padding=2), nn.ReLU(), nn.Conv1d(CHANNELS, CHANNELS, 5, 2), nn.ReLU(),
            nn.Conv1d(CHANNELS, CHANNELS, 5, 2), nn.ReLU(),
        )  # fmt: skip
        self.last = nn.Linear(2 * CHANNELS, 1)

    def forward(self, joints: torch.Tensor) -> torch.Tensor:
        """Return logits (B,) of joints (B, T, J, 3), metres."""
        about = joints - joints[:, :, :1] * joints.new_tensor([1.0, 0.0, 1.0])
        speed = 10 * torch.diff(joints, dim=1)
        seen = torch.cat([about[:, 1:], speed], -1).flatten(2).transpose(1, 2)
        found = self.layers(seen)
        return self.last(torch.cat([found.amax(-1), found.mean(-1)], -1))[:, 0]


def accuracy(true: torch.Tensor, made: torch.Tensor, rooms: np.ndarray, seed: int = 0) -> float:
    """Return the share of windows in held-out rooms that are classified correctly.

    true, made: joints (B, T, 22, 3) of the same windows, captured and generated. rooms: (B,) numbers.
    """
    torch.manual_seed(seed)
    units = np.random.default_rng(seed).permutation(np.unique(rooms))
    held = torch.as_tensor(np.isin(rooms, units[: max(int(round(HELD * len(units))), 1)]), device=true.device)
    judge = _Judge(true.shape[2]).to(true.device)
    adam = torch.optim.Adam(judge.parameters(), lr=RATE, weight_decay=1e-3)
    rows = (~held).nonzero()[:, 0]
    for _ in range(STEPS):
        chosen = rows[torch.randint(len(rows), (BATCH // 2,), device=true.device)]
        logits = judge(torch.cat([true[chosen], made[chosen]]))
        wanted = torch.cat([torch.ones(len(chosen)), torch.zeros(len(chosen))]).to(logits.device)
        loss = nn.functional.binary_cross_entropy_with_logits(logits, wanted)
        adam.zero_grad()
        loss.backward()
        adam.step()
    judge.eval()
    with torch.no_grad():
        right = [(judge(true[held]) > 0).float().mean(), (judge(made[held]) <= 0).float().mean()]
    return float(sum(right) / 2)
