"""Pretrain the scene encoder on depth (inverse Huber), normals and classes (section 3.1; the paper uses ImageNet).

python -m samp_blender.training.scene_gan.pretrain --data DATA/train --work ENCODER --view colour --seconds 3600
    [--tasks normals classes] [--published resnet18.safetensors] [--test DATA/test]

--tasks without depth gives the encoder of the rows without D. The view "height" is trained to encode its own maps. An
interrupted training is resumed. --test prints the depth error (RMSE, share within a factor of 1.25) on held-out rooms.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import torch
from torch import nn
from torch.nn import functional

from ...models.scene_gan import height_map, networks
from .data import dataset
from .data.dataset import Batch, Dataset
from .learning import curves, losses

TASKS = ("depth", "normals", "classes")
FARTHEST = 12.0  # largest depth (m) that counts
RATE = 5e-4


class HeightDecoder(nn.Module):
    """A decoder from a scene feature to its height map, only for pretraining."""

    def __init__(self, scene: int, width: int) -> None:
        super().__init__()
        side = height_map.CELLS // 16
        self.spread, self.shape = nn.Linear(scene, 2 * width * side * side), (2 * width, side, side)
        widths = (2 * width, 2 * width, width, width // 2, width // 2)
        self.blocks = nn.ModuleList(
            nn.Conv2d(a, b, 3, padding=1) for a, b in zip(widths[:-1], widths[1:], strict=True)
        )
        self.last = nn.Conv2d(widths[-1], 2, 3, padding=1)

    def forward(self, feature: torch.Tensor) -> torch.Tensor:
        """Return maps (B, 2, CELLS, CELLS)."""
        x = self.spread(feature).view(-1, *self.shape)
        for block in self.blocks:
            x = functional.leaky_relu(block(functional.interpolate(x, scale_factor=2)), 0.2)
        return self.last(x)


class Pretraining:
    """An encoder, its decoder and optimiser on a data set."""

    def __init__(
        self, data: Dataset, settings: networks.Settings, tasks: tuple[str, ...], seed: int = 0
    ) -> None:
        torch.manual_seed(seed)
        self.data, self.settings, self.tasks = data, settings, tasks
        self.random = torch.Generator().manual_seed(seed)
        self.encoder = networks.encoder(settings).to(data.device)
        self.extra = (
            HeightDecoder(settings.scene, settings.encoder_width).to(data.device)
            if self._height
            else nn.Module()
        )
        values = [*self.encoder.parameters(), *self.extra.parameters()]
        self.steps = torch.optim.Adam(values, RATE)
        self.step_number = 0

    @property
    def _height(self) -> bool:
        return self.settings.view == "height"

    def loss(self, batch: Batch) -> dict[str, torch.Tensor]:
        """Return the losses of a batch by task."""
        seen = self.data.views(self.settings.view, batch)
        feature = self.encoder(seen)
        if self._height:
            return {"height": (self.extra(feature) - seen).abs().mean()}
        depth, normal, classes = self.encoder.decoder(feature)
        targets = self.data.targets(batch)
        known = targets["known"]
        near = (known * (targets["depth"][:, 0] < FARTHEST))[:, None]
        found = {}
        if "depth" in self.tasks:
            found["depth"] = losses.inverse_huber(depth, targets["depth"], near)
        if "normals" in self.tasks:
            apart = 1 - (normal * targets["normal"]).sum(1)
            found["normals"] = (apart * known).sum() / known.sum().clamp(min=1)
        if "classes" in self.tasks and "classes" in targets:
            entropy = functional.cross_entropy(classes, targets["classes"], reduction="none")
            found["classes"] = (entropy * known).sum() / known.sum().clamp(min=1)
        return found

    def step(self, count: int, rate: float) -> dict[str, float]:
        """Take one step with ``count`` pictures; return the losses."""
        for group in self.steps.param_groups:
            group["lr"] = rate
        found = self.loss(self.data.sample(count, self.random))
        self.steps.zero_grad(set_to_none=True)
        sum(found.values()).backward()
        self.steps.step()
        self.step_number += 1
        return {name: float(value.detach()) for name, value in found.items()}

    @torch.no_grad()
    def depth_error(self, data: Dataset, count: int = 64) -> dict[str, float]:
        """Return RMSE (metres) and share within 1.25 of the depth of every picture's first pair in a data set."""
        self.encoder.eval()
        first = torch.as_tensor(_first_rows(data.small["pairs"][:, 0].cpu()), device=data.device)
        square, within, total = 0.0, 0.0, 0.0
        for at in range(0, len(first), count):
            batch = data.batch(first[at : at + count])
            made = self.encoder.decoder(self.encoder(data.views(self.settings.view, batch)))[0]
            true = data.targets(batch)["depth"]
            known = (true > 0) & (true < FARTHEST)
            ratio = torch.maximum(made / true.clamp(min=1e-3), true / made)
            square += float(((made - true).square() * known).sum())
            within += float(((ratio < 1.25) & known).sum())
            total += float(known.sum())
        self.encoder.train()
        return {
            "pictures": len(first),
            "rmse": (square / max(total, 1)) ** 0.5,
            "delta_1_25": within / max(total, 1),
        }

    def save(self, folder: Path) -> None:
        """Write the encoder and the state from which training can be resumed."""
        parts = {"encoder": self.encoder, "extra": self.extra, "steps": self.steps}
        state = {name: part.state_dict() for name, part in parts.items()}
        state |= {"random": self.random.get_state(), "step": self.step_number}
        torch.save(state, folder / "encoder.part")
        (folder / "encoder.part").replace(folder / "encoder.pt")
        notes = {name: getattr(self.settings, name) for name in ("view", "scene", "encoder_width")}
        (folder / "encoder.json").write_text(
            json.dumps(notes | {"tasks": self.tasks, "steps": self.step_number})
        )

    def resume(self, folder: Path) -> None:
        """Resume from a state written by `save`."""
        state = torch.load(folder / "encoder.pt", map_location=self.data.device, weights_only=True)
        self.encoder.load_state_dict(state["encoder"])
        self.extra.load_state_dict(state["extra"])
        self.steps.load_state_dict(state["steps"])
        self.random.set_state(state["random"].cpu())
        self.step_number = state["step"]


def _first_rows(values: torch.Tensor) -> list[int]:
    """Return the first row of each value."""
    found: dict[int, int] = {}
    for row, value in enumerate(values.tolist()):
        found.setdefault(value, row)
    return list(found.values())


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--test", type=Path)
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--view", choices=networks.VIEWS, default="colour")
    parser.add_argument("--tasks", nargs="+", choices=TASKS, default=TASKS)
    parser.add_argument("--published", type=Path, help="ResNet-18 weights with the usual names, .safetensors")
    parser.add_argument("--seconds", type=float, required=True)
    parser.add_argument("--encoder-width", type=int, default=64)
    parser.add_argument("--batch", type=int, default=32)
    parser.add_argument("--device", default="cuda" if torch.cuda.is_available() else "cpu")
    parser.add_argument("--threads", type=int, default=1)
    chosen = parser.parse_args(arguments)
    began = time.time()
    torch.set_num_threads(chosen.threads)
    chosen.work.mkdir(parents=True, exist_ok=True)
    resident = chosen.device != "cpu"
    data = dataset.load(chosen.data, chosen.device, resident)
    settings = networks.Settings(view=chosen.view, encoder_width=chosen.encoder_width)
    made = Pretraining(data, settings, tuple(chosen.tasks))
    if chosen.published is not None and chosen.view == "colour":
        from safetensors.torch import load_file

        made.encoder.load_published(load_file(chosen.published))
    if (chosen.work / "encoder.pt").exists():
        made.resume(chosen.work)
    start = reported = time.time()
    end = began + chosen.seconds - 5
    while (now := time.time()) < end:
        done = (now - start) / max(end - start, 1e-9)
        values = made.step(chosen.batch, RATE * (1 - done) + 1e-5)
        if now - reported > 20:
            reported = now
            curves.note(chosen.work / "log.jsonl", made.step_number, now - began, values)
            print(f"{now - began:.0f} s step {made.step_number} {values}", flush=True)
            made.save(chosen.work)
    made.save(chosen.work)
    if chosen.test is not None and chosen.view != "height":
        error = made.depth_error(dataset.load(chosen.test, chosen.device, resident))
        (chosen.work / "depth_error.json").write_text(json.dumps(error))
        print(error)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
