"""RouteNet, PoseNet and BaseNet of the paper (section 3.3, figure 3 (b), table 1).

They share one architecture: a bidirectional LSTM with both ends as input of every step, its features of all steps
concatenated with the cloud's feature, and two fully connected layers for all frames in between. The paper specifies
neither the inputs of a step nor the width of the LSTM: here they are both ends and the share of time, and 32 numbers in
each direction.
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

    ends: size of an end. outputs: size of a frame. route: size of a frame of the given route, or 0. scene: whether the
    cloud is an input.
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

    rotation: whether it predicts r as well, where RouteNet does not. route: whether the predicted route is an input,
    which it is not in the ablations of table 1.
    """
    numbers = POSE + HANDS + (ROTATION if rotation else 0)
    return WindowNet(numbers, numbers, TRANSLATION + ROTATION if route else 0, scene)


def base_net(scene: bool = True) -> WindowNet:
    """Return BaseNet of table 1: one network for route and pose."""
    return WindowNet(BODY, BODY, scene=scene)
