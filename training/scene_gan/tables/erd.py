"""Train the feature networks of Motion FID: ERD (encoder, LSTM, decoder; Fragkiadaki et al. 2015).

python -m samp_blender.training.scene_gan.tables.erd --data DATA/train --work ERD --steps 3000

They predict motion in windows of 16, 32 and 64 frames, one network each, as in section 4.3. They are trained on this
project's motion, so FIDs are not comparable with the paper's; the order of rows is.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import torch
from torch import nn

from ....models.scene_gan.projection import Motions
from ..data import dataset
from ..data.dataset import Dataset

LENGTHS = (16, 32, 64)
HIDDEN = 128
NUMBERS = 22 * 3 + 3


def frames(motions: Motions) -> torch.Tensor:
    """Return the inputs of ERD (B, 64, NUMBERS): joints relative to the pelvis, and its velocity (10 cm a frame).

    They are in the frame of the first frame's facing, and so independent of the camera.
    """
    positions, velocities = motions.positions[:, 1:], motions.velocities.transpose(1, 2)
    across = motions.positions[:, 0, 1] - motions.positions[:, 0, 2]
    yaw = torch.atan2(-across[:, 2], across[:, 0])
    cos, sin, zero, one = torch.cos(yaw), torch.sin(yaw), torch.zeros_like(yaw), torch.ones_like(yaw)
    axes = torch.stack(
        [torch.stack(row, -1) for row in ((cos, zero, sin), (zero, one, zero), (-sin, zero, cos))], -2
    )
    seen = [positions.flatten(1, 2) @ axes, 10 * velocities @ axes]
    return torch.cat([seen[0].view(*positions.shape[:2], -1), seen[1]], dim=-1)


class Erd(nn.Module):
    """A network that predicts the next frame from the previous ones; its features are the LSTM's last state."""

    def __init__(self, hidden: int = HIDDEN) -> None:
        super().__init__()
        self.encoder = nn.Sequential(nn.Linear(NUMBERS, hidden), nn.ReLU(), nn.Linear(hidden, hidden))
        self.recurrent = nn.LSTM(hidden, hidden, 1, batch_first=True)
        self.decoder = nn.Sequential(nn.Linear(hidden, hidden), nn.ReLU(), nn.Linear(hidden, NUMBERS))

    def forward(self, seen: torch.Tensor) -> torch.Tensor:
        """Return predictions (B, T, NUMBERS) of the frame after each (B, T, NUMBERS)."""
        return seen + self.decoder(self.recurrent(self.encoder(seen))[0])

    def features(self, seen: torch.Tensor) -> torch.Tensor:
        """Return features (B, hidden) of clips (B, T, NUMBERS)."""
        return self.recurrent(self.encoder(seen))[0][:, -1]


def train(data: Dataset, length: int, steps: int, batch: int = 64, seed: int = 0) -> tuple[Erd, float]:
    """Train a network for windows of ``length`` frames; return it with its last loss."""
    torch.manual_seed(seed)
    random = torch.Generator().manual_seed(seed)
    made = Erd().to(data.device)
    adam = torch.optim.Adam(made.parameters(), 1e-3)
    loss = torch.zeros(())
    for step in range(steps):
        adam.param_groups[0]["lr"] = 1e-3 * (1 - step / steps) + 1e-5
        seen = frames(data.sample(batch, random).motions)
        first = int(torch.randint(0, 64 - length + 1, (1,), generator=random))
        clip = seen[:, first : first + length]
        loss = (made(clip[:, :-1]) - clip[:, 1:]).square().mean()
        adam.zero_grad(set_to_none=True)
        loss.backward()
        nn.utils.clip_grad_norm_(made.parameters(), 1.0)
        adam.step()
    return made.eval(), float(loss.detach())


def load(folder: Path) -> dict[int, Erd]:
    """Return the trained networks by length."""
    found = {}
    for length in LENGTHS:
        found[length] = Erd()
        found[length].load_state_dict(torch.load(folder / f"erd_{length}.pt", weights_only=True))
        found[length].eval()
    return found


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--steps", type=int, default=3000)
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(1)
    data, notes = dataset.load(options.data), {}
    for length in LENGTHS:
        if (options.work / f"erd_{length}.pt").exists():
            continue
        began = time.time()
        made, notes[length] = train(data, length, options.steps)
        torch.save(made.state_dict(), options.work / f"erd_{length}.pt")
        print(f"{length} frames: loss {notes[length]:.5f}, {time.time() - began:.0f} s", flush=True)
    (options.work / "erd.json").write_text(json.dumps(notes))


if __name__ == "__main__":
    main()
