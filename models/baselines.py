"""The baselines of MotionNet in the paper (appendix C). They have no latent variable."""

from __future__ import annotations

import torch
from torch import nn
from torch.nn import functional

from . import state
from .motion_net import HIDDEN, LATENT, OBJECT, OBJECT_CODE, MotionNet, three_layers


class PlainDecoder(nn.Module):
    """Decoder of figure S.4: the interaction encoder and four fully connected layers."""

    def __init__(self, hidden: int = HIDDEN, postures: int = 0) -> None:
        super().__init__()
        self.interaction_encoder = three_layers((OBJECT, 256, 256, OBJECT_CODE))
        sizes = (state.SIZE + OBJECT_CODE + postures, hidden, hidden, hidden, state.SIZE)
        self.layers = nn.ModuleList([nn.Linear(a, b) for a, b in zip(sizes[:-1], sizes[1:], strict=True)])

    def forward(
        self, z: torch.Tensor, x: torch.Tensor, features: torch.Tensor, mix_weights: bool = False
    ) -> torch.Tensor:
        """Predict the next state; see models.motion_net.Decoder.forward. z and mix_weights are ignored."""
        h = torch.cat([x, self.interaction_encoder(features[:, :OBJECT]), features[:, OBJECT:]], -1)
        for layer in self.layers[:-1]:
            h = functional.elu(layer(h))
        return self.layers[-1](h)


class _Deterministic(MotionNet):
    """A network whose latent variable z is always zero."""

    def encode(
        self, x: torch.Tensor, y: torch.Tensor, features: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Return mean zero and log-variance zero (B, 64), with which the KL divergence vanishes."""
        zero = torch.zeros(len(x), LATENT, device=x.device)
        return zero, zero

    def step(
        self, x: torch.Tensor, features: torch.Tensor, z: torch.Tensor, mix_weights: bool = False
    ) -> torch.Tensor:
        """Predict the next state; see MotionNet.step. z is ignored."""
        return super().step(x, features, torch.zeros_like(z), mix_weights)


class Mlp(_Deterministic):
    """The MLP of the paper's tables."""

    def __init__(self, hidden: int = HIDDEN, postures: int = 0) -> None:
        super().__init__(hidden, postures)
        self.decoder = PlainDecoder(hidden, postures)


class MixtureOfExperts(_Deterministic):
    """The MoE of the paper's tables: MotionNet's decoder with z = 0."""


NETWORKS: dict[str, type[MotionNet]] = {"motion_net": MotionNet, "mlp": Mlp, "moe": MixtureOfExperts}


def hidden_width(tensors: dict[str, torch.Tensor]) -> int:
    """Return the width of the prediction network from its weights."""
    return tensors["decoder.layers.0.bias"].shape[-1]


def posture_count(tensors: dict[str, torch.Tensor]) -> int:
    """Return the number of inputs that describe the posture of the rest, from the weights."""
    return tensors["object_mean"].shape[0] - OBJECT
