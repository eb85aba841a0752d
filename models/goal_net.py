"""GoalNet (section 3.2, figure 4, appendix B.2): a conditional VAE of goals on an object.

The paper specifies the sizes of the interaction encoder and the latent code, and the loss. The two hidden layers of 256
after the interaction encoder are a choice of this project, since the paper does not state their sizes. One network
serves both actions, which are a one-hot input next to the object's code.

Goals are six numbers (position 3, direction 3) in the frame of the object's voxel grid: origin at the grid's centre,
axes of the grid, metres. Positions are divided by POSITION_SCALE and directions weighted, so that 0.1 m has about the
same weight in the loss as 13 degrees.
"""

from __future__ import annotations

from pathlib import Path

import torch
from torch import nn

from . import weights

ACTIONS = ("sit", "lie")
OBJECT = 2048
OBJECT_CODE = 64
LATENT = 3
HIDDEN = 256
GOAL = 6
DIRECTION_WEIGHT = 3.0  # of squared direction errors relative to squared errors of the scaled position
POSITION_SCALE = 0.25


def _layers(*sizes: int) -> nn.Sequential:
    stack: list[nn.Module] = []
    for inputs, outputs in zip(sizes[:-1], sizes[1:], strict=True):
        stack += [nn.Linear(inputs, outputs), nn.ELU()]
    return nn.Sequential(*stack[:-1])


class GoalNet(nn.Module):
    """Encoder (object, action, goal) -> z and decoder (object, action, z) -> goal."""

    def __init__(self) -> None:
        super().__init__()
        condition = OBJECT_CODE + len(ACTIONS)
        self.interaction_encoder = _layers(OBJECT, 512, 512, OBJECT_CODE)
        self.encoder = _layers(condition + GOAL, HIDDEN, HIDDEN, 2 * LATENT)
        self.decoder = _layers(condition + LATENT, HIDDEN, HIDDEN, GOAL)
        # Standard deviation of z for sampling, for each action; fitted after training.
        self.register_buffer("temperature", torch.ones(len(ACTIONS)))

    def condition(self, features: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
        """Return the condition (B, 66) of objects (B, 2048) and actions (B,), indices into ACTIONS."""
        return torch.cat(
            [self.interaction_encoder(features), nn.functional.one_hot(action, len(ACTIONS))], dim=1
        )

    def encode(self, condition: torch.Tensor, goal: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return mean and log-variance (B, 3) of z for goals (B, 6), metres."""
        mean, log_variance = self.encoder(torch.cat([condition, _to_units(goal)], dim=1)).chunk(2, dim=1)
        return mean, log_variance.clamp(-12.0, 6.0)

    def decode(self, condition: torch.Tensor, z: torch.Tensor) -> torch.Tensor:
        """Return goals (B, 6) for z (B, 3): position in metres, direction as predicted, of about unit length."""
        return _to_metres(self.decoder(torch.cat([condition, z], dim=1)))

    def draw(self, condition: torch.Tensor, noise: torch.Tensor) -> torch.Tensor:
        """Return goals (B, 6) for conditions (B, 66) and standard normal noise (B, 3)."""
        action = condition[:, -len(ACTIONS) :].argmax(1)
        return self.decode(condition, noise * self.temperature[action, None])

    def forward(
        self, features: torch.Tensor, action: torch.Tensor, goal: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Return reconstructed goals (B, 6), and mean and log-variance (B, 3) of the sampled z."""
        condition = self.condition(features, action)
        mean, log_variance = self.encode(condition, goal)
        z = mean + torch.randn_like(mean) * torch.exp(0.5 * log_variance)
        return self.decode(condition, z), mean, log_variance


def loss(
    predicted: torch.Tensor,
    goal: torch.Tensor,
    mean: torch.Tensor,
    log_variance: torch.Tensor,
    beta: float | torch.Tensor,
) -> torch.Tensor:
    """Return the loss of equation 4, averaged over the batch: scaled squared errors and beta times the KL divergence.

    predicted, goal: (B, 6). mean, log_variance: (B, 3). beta: a number, or one for each row (B,).
    """
    error = (_to_units(predicted) - _to_units(goal)).square()
    error = error[:, :3].sum(dim=1) + DIRECTION_WEIGHT * error[:, 3:].sum(dim=1)
    divergence = 0.5 * (mean.square() + log_variance.exp() - 1 - log_variance).sum(dim=1)
    return (error + beta * divergence).mean()


def set_error(drawn: torch.Tensor, labels: torch.Tensor, present: torch.Tensor) -> torch.Tensor:
    """Return the distance (), as sets, between goals drawn on objects and their labels.

    drawn: (B, K, 6) goals of B objects. labels: (B, G, 6). present: (B, G), False for padding. The distance is the mean
    squared error of a goal to the nearest label, plus that of a label to the nearest goal, scaled as in the loss. The
    second term preserves the diversity of the labels.
    """
    units = [_to_units(goals.flatten(0, 1)).unflatten(0, goals.shape[:2]) for goals in (drawn, labels)]
    error = (units[0][:, :, None] - units[1][:, None]).square()
    error = error[..., :3].sum(-1) + DIRECTION_WEIGHT * error[..., 3:].sum(-1)
    to_labels = error.masked_fill(~present[:, None], torch.inf).min(2).values.mean()
    to_goals = error.min(1).values
    return to_labels + (to_goals * present).sum() / present.sum()


def load(folder: Path | None = None) -> GoalNet:
    """Return the trained network in evaluation mode.

    folder: of the weights, by default the shipped ones. Raise weights.WeightsError for a file that is missing, damaged
    or does not fit the network.
    """
    net = GoalNet()
    weights.fill(net, weights.load_weights("goal_net", folder), weights.weights_path("goal_net", folder))
    return net.eval()


def _to_units(goal: torch.Tensor) -> torch.Tensor:
    return torch.cat([goal[:, :3] / POSITION_SCALE, goal[:, 3:]], dim=1)


def _to_metres(goal: torch.Tensor) -> torch.Tensor:
    return torch.cat([goal[:, :3] * POSITION_SCALE, goal[:, 3:]], dim=1)
