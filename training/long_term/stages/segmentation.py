"""Pretrain PointNet: the thirteen classes of the points around a place (section 3.2, implementation details)."""

from __future__ import annotations

import torch
from torch import nn

from ....models.long_term import layout
from ....models.long_term.point_net import PointNet
from ..data import Frame, LongTermData
from .learner import Learner

POINTS = 1024
RADIUS = 2.0  # metres
TALL = 10.0  # metres; includes ceilings


class PointLearner(Learner):
    """The training of PointNet on crops of rooms around bodies, with random yaw."""

    def __init__(self, data: LongTermData, batch: int = 16, points: int = POINTS) -> None:
        super().__init__("long_term_points", PointNet(), data, batch)
        self.points = points

    def losses(self, done: float) -> dict[str, torch.Tensor]:
        points, classes = draw(self.data, self.batch, self.points)
        logits = self.net(points)
        loss = nn.functional.cross_entropy(logits.flatten(0, 1), classes.flatten())
        return {"loss": loss, "accuracy": (logits.argmax(-1) == classes).float().mean()}


def draw(data: LongTermData, batch: int, points: int) -> tuple[torch.Tensor, torch.Tensor]:
    """Return clouds (B, P, 3) and the classes (B, P) of their points."""
    rows = torch.randint(len(data), (batch,), device=data.device)
    rooms = data.rooms[data.episode[rows]]
    places = data.root[rows] * data.root.new_tensor([1.0, 0.0, 1.0])
    back = layout.about_y(torch.rand(batch, device=data.device) * 2 * torch.pi)
    chosen = data.near(rooms, places[:, None], points, RADIUS, tall=TALL)
    cloud = torch.gather(data.points[rooms], 1, chosen[..., None].expand(-1, -1, 3))
    return Frame(places, back, rooms).points(cloud), torch.gather(data.classes[rooms], 1, chosen)


@torch.no_grad()
def accuracy(net: PointNet, data: LongTermData, batches: int = 40, batch: int = 16) -> float:
    """Return the share of correctly classified points."""
    right = []
    for _ in range(batches):
        points, classes = draw(data, batch, POINTS)
        right.append((net(points).argmax(-1) == classes).float().mean())
    return float(torch.stack(right).mean())
