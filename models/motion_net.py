"""MotionNet (section 3.1, figure 3, table S.3): an autoregressive conditional VAE with a mixture-of-experts decoder."""

from __future__ import annotations

import math

import torch
from torch import nn
from torch.nn import functional

from . import state

LATENT = 64
EXPERTS = 12
OBJECT = 2048
OBJECT_CODE = 256
# Width of the prediction network. The paper has 512; half of it learns as well from this much data, in half the time.
HIDDEN = 256
# Share of the present course (state.extrapolate) in the next state; the decoder tells the rest. All of it, and errors
# would never die away; none of it, and thousands of steps of training go into repeating what is already known.
EXTRAPOLATED_SHARE = 0.75
ENCODER = ("state_encoder", "interaction_encoder", "mean", "log_variance")
"""Attributes of MotionNet that make up its encoder."""
WEIGHTS_FIRST_ROWS = 4  # rows of a batch from which the experts' weights are multiplied from the left


def three_layers(sizes: tuple[int, int, int, int]) -> nn.Sequential:
    """A fully connected network of three layers with ELU between them; sizes of input and each layer."""
    a, b, c, d = sizes
    return nn.Sequential(nn.Linear(a, b), nn.ELU(), nn.Linear(b, c), nn.ELU(), nn.Linear(c, d))


class ExpertLayer(nn.Module):
    """One layer of all experts, mixed by the gate (equation 2).

    The experts' outputs are mixed, not their weights: the same mathematics, since the layer is linear before its
    activation, but one matrix product serves every sample of the batch.
    """

    def __init__(self, inputs: int, outputs: int, experts: int = EXPERTS) -> None:
        super().__init__()
        bound = math.sqrt(6.0 / inputs) * 0.5
        self.weight = nn.Parameter(torch.empty(inputs, experts, outputs).uniform_(-bound, bound))
        self.bias = nn.Parameter(torch.zeros(experts, outputs))
        self._rows: tuple[int, torch.Tensor] | None = None

    def forward(self, x: torch.Tensor, gate: torch.Tensor) -> torch.Tensor:
        """x: (B, inputs), gate: (B, experts). Returns (B, outputs)."""
        if not self.training and len(x) >= WEIGHTS_FIRST_ROWS:
            return self._weights_first(x, gate)
        each = (x @ self.weight.flatten(1)).unflatten(1, self.bias.shape)
        mixed = torch.bmm(gate[:, None], each)[:, 0]
        return mixed + gate @ self.bias

    def _weights_first(self, x: torch.Tensor, gate: torch.Tensor) -> torch.Tensor:
        """The same product with the weights on the left: for some ten rows, the libraries are half as quick again."""
        if self._rows is None or self._rows[0] != self.weight._version:
            self._rows = self.weight._version, self.weight.detach().flatten(1).t().contiguous()
        each = (self._rows[1] @ x.t()).unflatten(0, self.bias.shape)
        return (each * gate.t()[:, None]).sum(0).t() + gate @ self.bias

    def forward_mixed_weights(self, x: torch.Tensor, gate: torch.Tensor) -> torch.Tensor:
        """The same by equation 2 to the letter, a weight matrix for each sample: slow, for tests and benchmarks."""
        weight = torch.einsum("bk,iko->bio", gate, self.weight)
        return torch.bmm(x[:, None], weight)[:, 0] + gate @ self.bias


class Decoder(nn.Module):
    """Gating network and prediction network: z, the object's code and the state before give the next state."""

    def __init__(self, size: int = state.SIZE, hidden: int = HIDDEN) -> None:
        super().__init__()
        self.interaction_encoder = three_layers((OBJECT, 256, 256, OBJECT_CODE))
        self.gate = three_layers((LATENT + size, 512, 256, EXPERTS))
        self.layers = nn.ModuleList(
            [
                ExpertLayer(LATENT + size + OBJECT_CODE, hidden),
                ExpertLayer(LATENT + hidden, hidden),
                ExpertLayer(LATENT + hidden, size),
            ]
        )

    def forward(
        self, z: torch.Tensor, x: torch.Tensor, features: torch.Tensor, mix_weights: bool = False
    ) -> torch.Tensor:
        """z: (B, 64), x: (B, 647), features: (B, 2048); normalised in and out. Returns (B, 647)."""
        gate = torch.softmax(self.gate(torch.cat([z, x], -1)), -1)
        h = torch.cat([x, self.interaction_encoder(features)], -1)
        for k, layer in enumerate(self.layers):
            step = layer.forward_mixed_weights if mix_weights else layer.forward
            h = step(torch.cat([z, h], -1), gate)
            h = functional.elu(h) if k < len(self.layers) - 1 else h
        return h


class MotionNet(nn.Module):
    """The whole network. Buffers hold the normalisation of inputs, targets and the object's features.

    The decoder tells the next state as its difference from a share of the course that the present one is on: a
    frame is a thirtieth of a second, and most of what follows is already said.
    """

    def __init__(self, hidden: int = HIDDEN) -> None:
        super().__init__()
        self.state_encoder = three_layers((2 * state.SIZE, 512, 256, 256))
        self.interaction_encoder = three_layers((OBJECT, 256, 256, OBJECT_CODE))
        self.mean = nn.Linear(256 + OBJECT_CODE, LATENT)
        self.log_variance = nn.Linear(256 + OBJECT_CODE, LATENT)
        self.decoder = Decoder(hidden=hidden)
        for name, size in (("input", state.SIZE), ("target", state.SIZE), ("object", OBJECT)):
            self.register_buffer(f"{name}_mean", torch.zeros(size))
            self.register_buffer(f"{name}_std", torch.ones(size))

    def drop_encoder(self) -> None:
        """Remove the encoder, which only training needs and which is not shipped; `encode` fails afterwards."""
        for part in ENCODER:
            delattr(self, part)

    def normalised_object(self, features: torch.Tensor) -> torch.Tensor:
        """The object's features (B, 2048), normalised."""
        return (features - self.object_mean) / self.object_std

    def encode(
        self, x: torch.Tensor, y: torch.Tensor, features: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Mean and log-variance (B, 64) of Q(Z | X_i, X_i-1, I). x: states (B, 647), y: change (B, 647); all
        normalised."""
        code = self.interaction_encoder(features)
        h = torch.cat([self.state_encoder(torch.cat([y, x], -1)), code], -1)
        return self.mean(h), self.log_variance(h).clamp(-8.0, 4.0)

    def step(
        self, x: torch.Tensor, features: torch.Tensor, z: torch.Tensor, mix_weights: bool = False
    ) -> torch.Tensor:
        """The next states (B, 647), told in the root frame of x.

        x: (B, 647) as state.py lays it out; features: (B, 2048) of the object; neither normalised. z: (B, 64).
        """
        y = self.decoder(
            z, (x - self.input_mean) / self.input_std, self.normalised_object(features), mix_weights
        )
        return self.next_state(y, x)

    def change(self, y: torch.Tensor, x: torch.Tensor) -> torch.Tensor:
        """What the decoder has to say so that the states y (B, 647) follow the states x (B, 647)."""
        return (y - EXTRAPOLATED_SHARE * state.extrapolate(x) - self.target_mean) / self.target_std

    def next_state(self, change: torch.Tensor, x: torch.Tensor) -> torch.Tensor:
        """The states (B, 647) that follow the states x (B, 647) when the decoder says ``change`` (B, 647)."""
        return EXTRAPOLATED_SHARE * state.extrapolate(x) + change * self.target_std + self.target_mean
