"""The base of all training stages: optimiser, running average of the weights, reports and checkpoints."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from pathlib import Path

import torch
from torch import nn

from ....models import weights
from ....models.long_term.point_net import PointEncoder
from ..data import LongTermData

WARM_UP = 100  # steps
CLIP = 1.0  # largest norm of the gradient
AVERAGE = 0.998  # decay of the running average of the weights, per step
LEAST_RATE = 0.02  # share of the learning rate at the end


class Learner(ABC):
    """The training of one network.

    name: of the weights file. Subclasses compute the losses of a random batch; ``losses["loss"]`` is minimised, the
    others are reported.
    """

    def __init__(self, name: str, net: nn.Module, data: LongTermData, batch: int, rate: float = 1e-3) -> None:
        self.name, self.data, self.batch, self.rate = name, data, batch, rate
        self.net = net.to(data.device).train()
        self.adam = torch.optim.Adam(self.net.parameters(), lr=rate)
        self._restart_average()
        self.step_number = 0
        self._sums: dict[str, torch.Tensor] = {}
        self._count = 0

    @abstractmethod
    def losses(self, done: float) -> dict[str, torch.Tensor]:
        """Return the losses of a random batch. done: share of the training, 0 to 1."""

    def step(self, done: float) -> None:
        """Take one step of the optimiser."""
        falling = LEAST_RATE + (1 - LEAST_RATE) * (1 + math.cos(math.pi * min(done, 1.0))) / 2
        for group in self.adam.param_groups:
            group["lr"] = self.rate * falling * min(1.0, (self.step_number + 1) / WARM_UP)
        losses = self.losses(done)
        self.adam.zero_grad(set_to_none=True)
        losses["loss"].backward()
        norm = nn.utils.clip_grad_norm_(self.net.parameters(), CLIP)
        if torch.isfinite(norm):
            self.adam.step()
        self.step_number += 1
        share = min(AVERAGE, 1 - 1 / (1 + self.step_number))
        with torch.no_grad():
            for key, value in self.net.state_dict().items():
                self.average[key].lerp_(value, 1 - share)
        for key, value in losses.items():
            self._sums[key] = self._sums.get(key, 0) + value.detach()
        self._count += 1

    def report(self) -> str:
        """Return the mean losses since the last report."""
        count = max(self._count, 1)
        text = " ".join(f"{name} {float(value) / count:.4f}" for name, value in self._sums.items())
        self._sums, self._count = {}, 0
        return f"{self.name} step {self.step_number} {text}"

    def checkpoint(self) -> dict:
        """Return the state from which a training can be resumed."""
        return {
            "net": self.net.state_dict(), "adam": self.adam.state_dict(), "average": self.average,
            "step": self.step_number,
        }  # fmt: skip

    def begin_with(self, folder: Path) -> None:
        """Load the network's weights of another training from a folder. Raise WeightsError where they do not fit."""
        tensors = weights.load_weights(self.name, folder)
        full = {k: v.float() if v.is_floating_point() else v for k, v in tensors.items()}
        weights.fill(self.net, full, weights.weights_path(self.name, folder))
        self._restart_average()

    def _restart_average(self) -> None:
        """Begin the running average with the network's present weights."""
        self.average = {k: v.detach().clone() for k, v in self.net.state_dict().items()}

    def resume(self, state: dict) -> None:
        """Resume from a checkpoint."""
        self.net.load_state_dict(state["net"])
        self.adam.load_state_dict(state["adam"])
        self.average = {k: v.to(self.data.device) for k, v in state["average"].items()}
        self.step_number = state["step"]

    def save(self, folder: Path) -> Path:
        """Write the averaged weights."""
        return weights.save_weights(self.name, self.average, folder)


def trained(name: str, net: nn.Module, folder: Path, device: torch.device) -> nn.Module:
    """Return a network with the fixed weights of an earlier stage."""
    weights.fill(net, weights.load_weights(name, folder), weights.weights_path(name, folder))
    return net.to(device).eval().requires_grad_(False)


def with_pretrained_scene(net: nn.Module, encoder: PointEncoder | None) -> nn.Module:
    """Return a network with its point encoders initialised from the pretrained one; None leaves them unchanged."""
    if encoder is not None:
        for part in net.modules():
            if isinstance(part, PointEncoder):
                part.load_state_dict(encoder.state_dict())
    return net
