"""RouteNet, PoseNet and BaseNet as the paper has them (section 3.3, figure 3 (b), table 1).

All of them are one architecture: a two-way LSTM that sees both ends in every step, its features of all steps next to
the cloud's feature, and two fully connected layers for all frames in between. The paper does not say what the LSTM
takes in each step nor how wide it is: here both ends and the share of the time, and 32 numbers each way.
"""

from __future__ import annotations

import torch
from torch import nn

from .layout import BODY, FRAMES, HANDS, POSE, ROTATION, SCENE, TRANSLATION
from .point_net import PointEncoder

HIDDEN = 32
WIDTH = 512
INNER = FRAMES - 2


class WindowNet(nn.Module):
    """Ends (B, E) and cloud (B, N, 3) -> the frames between them (B, 59, O).

    ends: numbers of an end. outputs: numbers of a frame. route: numbers of a predicted frame that is given, or 0.
    scene: whether the cloud is seen.
    """

    def __init__(self, ends: int, outputs: int, route: int = 0, scene: bool = True) -> None:
        super().__init__()
        self.outputs, self.route = outputs, route
        self.scene = PointEncoder() if scene else None
        self.lstm = nn.LSTM(2 * ends + 1, HIDDEN, batch_first=True, bidirectional=True)
        features = INNER * (2 * HIDDEN + route) + (SCENE if scene else 0)
        self.first, self.second = nn.Linear(features, WIDTH), nn.Linear(WIDTH, INNER * outputs)

    def forward(
        self,
        start: torch.Tensor,
        end: torch.Tensor,
        cloud: torch.Tensor | None = None,
        route: torch.Tensor | None = None,
    ) -> torch.Tensor:
        """Return the frames (B, 59, O). start, end: (B, E). route: (B, 59, R)."""
        share = torch.linspace(0, 1, FRAMES, device=start.device, dtype=start.dtype)[1:-1]
        steps = torch.cat([start, end], -1)[:, None].expand(-1, INNER, -1)
        inputs = torch.cat([steps, share[None, :, None].expand(len(start), -1, -1)], -1)
        features = self.lstm(inputs)[0]
        if route is not None:
            features = torch.cat([features, route], -1)
        flat = features.flatten(1)
        if self.scene is not None:
            flat = torch.cat([flat, self.scene(cloud)], -1)
        made = self.second(nn.functional.leaky_relu(self.first(flat), 0.2))
        return made.unflatten(-1, (INNER, self.outputs))


def route_net(rotation: bool = True, scene: bool = True) -> WindowNet:
    """Return RouteNet, equation 1; without rotation, RouteNet(t) of table 1."""
    given = TRANSLATION + ROTATION
    return WindowNet(given, given if rotation else TRANSLATION, scene=scene)


def pose_net(rotation: bool = False, route: bool = True, scene: bool = True) -> WindowNet:
    """Return PoseNet, equation 2.

    rotation: whether it predicts r too, because RouteNet does not. route: whether it is given the predicted route; the
    ablations of table 1 are not.
    """
    numbers = POSE + HANDS + (ROTATION if rotation else 0)
    return WindowNet(numbers, numbers, TRANSLATION + ROTATION if route else 0, scene)


def base_net(scene: bool = True) -> WindowNet:
    """Return BaseNet of table 1: one network for route and pose."""
    return WindowNet(BODY, BODY, scene=scene)
