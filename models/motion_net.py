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
POSTURES = 9  # inputs after the object's features that describe the posture of the rest at the end of a take
STYLES = 128  # codes of captured motion stored for each action, from which the held components of z are drawn
POSTURE_ROWS = 32  # combinations of postures stored with their shares in the training data
# Width of the prediction network. The paper uses 512; with this amount of data, half of it is as accurate in half the
# time.
HIDDEN = 256
# Share of the extrapolated state (state.extrapolate) in the next one; the decoder predicts the rest. With 1, errors
# would never decay; with 0, thousands of training steps are needed to learn the extrapolation.
EXTRAPOLATED_SHARE = 0.75
ENCODER = ("state_encoder", "interaction_encoder", "mean", "log_variance")
"""Attributes of MotionNet that make up its encoder."""
PAD_ON_GPU = True  # whether matrix sizes are padded to multiples of eight on a GPU
WEIGHTS_FIRST_ROWS = 4  # batch size from which the weights are the left factor of the product


def three_layers(sizes: tuple[int, int, int, int]) -> nn.Sequential:
    """Return three fully connected layers with ELU in between. sizes: of the input and of each layer."""
    a, b, c, d = sizes
    return nn.Sequential(nn.Linear(a, b), nn.ELU(), nn.Linear(b, c), nn.ELU(), nn.Linear(c, d))


class ExpertLayer(nn.Module):
    """One layer of all experts, mixed by the gate (equation 2).

    The experts' outputs are mixed instead of their weights. The result is the same, since the layer is linear before
    its activation, but a single matrix product serves the whole batch.
    """

    def __init__(self, inputs: int, outputs: int, experts: int = EXPERTS) -> None:
        super().__init__()
        bound = math.sqrt(6.0 / inputs) * 0.5
        self.weight = nn.Parameter(torch.empty(inputs, experts, outputs).uniform_(-bound, bound))
        self.bias = nn.Parameter(torch.zeros(experts, outputs))
        self._transposed: tuple[int, torch.Tensor] | None = None

    def forward(self, x: torch.Tensor, gate: torch.Tensor) -> torch.Tensor:
        """Return outputs (B, outputs) of x (B, inputs), mixed by gate (B, experts)."""
        if not self.training and len(x) >= WEIGHTS_FIRST_ROWS:
            return self._weights_first(x, gate)
        weight, outputs = self.weight, self.bias.shape[1]
        if x.is_cuda and PAD_ON_GPU:
            # Tensor cores need row lengths that are multiples of eight; other sizes run at a fraction of the speed.
            pad_in, pad_out = -x.shape[1] % 8, -outputs % 8
            x, weight = functional.pad(x, (0, pad_in)), functional.pad(weight, (0, pad_out, 0, 0, 0, pad_in))
        each = (x @ weight.flatten(1)).unflatten(1, weight.shape[1:])
        mixed = torch.bmm(gate[:, None], each)[:, 0, :outputs]
        return mixed + gate @ self.bias

    def _weights_first(self, x: torch.Tensor, gate: torch.Tensor) -> torch.Tensor:
        """Compute the same product with the weights as left factor: 1.5 times as fast for about ten rows."""
        if self._transposed is None or self._transposed[0] != self.weight._version:
            self._transposed = self.weight._version, self.weight.detach().flatten(1).t().contiguous()
        each = (self._transposed[1] @ x.t()).unflatten(0, self.bias.shape)
        return (each * gate.t()[:, None]).sum(0).t() + gate @ self.bias

    def forward_mixed_weights(self, x: torch.Tensor, gate: torch.Tensor) -> torch.Tensor:
        """Compute the same by equation 2, with a weight matrix for each sample; slow, for tests and benchmarks."""
        weight = torch.einsum("bk,iko->bio", gate, self.weight)
        return torch.bmm(x[:, None], weight)[:, 0] + gate @ self.bias


class Decoder(nn.Module):
    """Gating network and prediction network: the next state from z, the object's code and the previous state.

    postures: number of features that describe the posture of the rest, which bypass the interaction encoder.
    """

    def __init__(self, size: int = state.SIZE, hidden: int = HIDDEN, postures: int = 0) -> None:
        super().__init__()
        self.interaction_encoder = three_layers((OBJECT, 256, 256, OBJECT_CODE))
        self.gate = three_layers((LATENT + size, 512, 256, EXPERTS))
        self.layers = nn.ModuleList(
            [
                ExpertLayer(LATENT + size + OBJECT_CODE + postures, hidden),
                ExpertLayer(LATENT + hidden, hidden),
                ExpertLayer(LATENT + hidden, size),
            ]
        )

    def forward(
        self, z: torch.Tensor, x: torch.Tensor, features: torch.Tensor, mix_weights: bool = False
    ) -> torch.Tensor:
        """Return (B, 647) for z (B, 64), x (B, 647) and features (B, 2048 + postures); all are normalised.

        mix_weights: mix the experts' weights instead of their outputs; slow.
        """
        gate = torch.softmax(self.gate(torch.cat([z, x], -1)), -1)
        h = torch.cat([x, self.interaction_encoder(features[:, :OBJECT]), features[:, OBJECT:]], -1)
        for k, layer in enumerate(self.layers):
            step = layer.forward_mixed_weights if mix_weights else layer.forward
            h = step(torch.cat([z, h], -1), gate)
            h = functional.elu(h) if k < len(self.layers) - 1 else h
        return h


class MotionNet(nn.Module):
    """The complete network. Buffers hold the normalisation of inputs, targets and the object's features.

    The decoder predicts the difference between the next state and a share of the extrapolated one, since within a
    thirtieth of a second most of the next state follows from the current one.

    postures: 0 or POSTURES, the number of inputs after the object's features that describe the posture of the rest.
    With them, posture_rows (32, 9) and posture_shares (32,) are the combinations in the training data, of zeros and
    ones, and their shares among sits and among lies; style_postures are the postures of the captured styles.
    """

    def __init__(self, hidden: int = HIDDEN, postures: int = 0) -> None:
        super().__init__()
        self.state_encoder = three_layers((2 * state.SIZE, 512, 256, 256))
        self.interaction_encoder = three_layers((OBJECT, 256, 256, OBJECT_CODE))
        self.mean = nn.Linear(256 + OBJECT_CODE + postures, LATENT)
        self.log_variance = nn.Linear(256 + OBJECT_CODE + postures, LATENT)
        self.decoder = Decoder(hidden=hidden, postures=postures)
        self.postures = postures
        # Number of leading components of z that are drawn once for a whole take; the others are drawn every frame.
        self.register_buffer("held", torch.zeros((), dtype=torch.int64))
        # Held components of z of captured motion, first in each row, for each action; zero if they are drawn from
        # N(0, 1).
        self.register_buffer("style_codes", torch.zeros(state.ACTIONS, STYLES, LATENT))
        # Whether goals are at the resting pelvis, with the object's grid centred on them. Otherwise, goals on deep
        # seats are in front of the body, and the grid covers the whole object.
        self.register_buffer("goal_grid", torch.zeros((), dtype=torch.int64))
        for name, size in (("input", state.SIZE), ("target", state.SIZE), ("object", OBJECT + postures)):
            self.register_buffer(f"{name}_mean", torch.zeros(size))
            self.register_buffer(f"{name}_std", torch.ones(size))
        if postures:
            self.register_buffer("posture_rows", torch.zeros(POSTURE_ROWS, postures))
            self.register_buffer("posture_shares", torch.zeros(POSTURE_ROWS))
            self.register_buffer("style_postures", torch.zeros(state.ACTIONS, STYLES, postures))

    def drop_encoder(self) -> None:
        """Remove the encoder, which is only needed for training and not shipped; `encode` fails afterwards."""
        for part in ENCODER:
            delattr(self, part)

    def normalised_object(self, features: torch.Tensor) -> torch.Tensor:
        """Normalise the object's features (B, 2048 + postures); postures are unchanged."""
        return (features - self.object_mean) / self.object_std

    def encode(
        self, x: torch.Tensor, y: torch.Tensor, features: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Return mean and log-variance (B, 64) of Q(Z | X_i, X_i-1, I).

        x: states (B, 647). y: changes (B, 647), see `change`. features: (B, 2048 + postures). All are normalised.
        """
        code = self.interaction_encoder(features[:, :OBJECT])
        h = torch.cat([self.state_encoder(torch.cat([y, x], -1)), code, features[:, OBJECT:]], -1)
        return self.mean(h), self.log_variance(h).clamp(-8.0, 4.0)

    def step(
        self, x: torch.Tensor, features: torch.Tensor, z: torch.Tensor, mix_weights: bool = False
    ) -> torch.Tensor:
        """Predict the next states (B, 647), expressed in the root frame of x.

        x: (B, 647) in the layout of state.py; features: (B, 2048 + postures) of the object and the posture;
        neither is normalised. z: (B, 64).
        """
        y = self.decoder(
            z, (x - self.input_mean) / self.input_std, self.normalised_object(features), mix_weights
        )
        return self.next_state(y, x)

    def change(self, y: torch.Tensor, x: torch.Tensor) -> torch.Tensor:
        """Return the decoder output (B, 647) that leads from states x (B, 647) to y (B, 647); see `next_state`."""
        return (y - EXTRAPOLATED_SHARE * state.extrapolate(x) - self.target_mean) / self.target_std

    def next_state(self, change: torch.Tensor, x: torch.Tensor) -> torch.Tensor:
        """Return the states (B, 647) that follow states x (B, 647) for a decoder output ``change`` (B, 647)."""
        return EXTRAPOLATED_SHARE * state.extrapolate(x) + change * self.target_std + self.target_mean
