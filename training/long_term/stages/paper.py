"""The networks of the paper's table 1: windows of 61 frames, equations 3 and 4, p of the prior.

Names are those of the files: route, route_t, pose, pose_r (without a given route), pose_rt (predicts r as well), base;
the suffix `_blind` means without scene.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch

from ....models.long_term import window_net
from ....models.long_term.layout import FRAMES, POSE, ROTATION, TRANSLATION
from ....models.long_term.point_net import PointEncoder
from ....models.long_term.pose_prior import PosePrior
from ....models.long_term.window_net import WindowNet
from ..data import LongTermData, Windows
from . import windows
from .learner import Learner, with_pretrained_scene

HANDS_WEIGHT = 0.1  # lambda_h
PLACE = TRANSLATION + ROTATION


@dataclass(frozen=True)
class Kind:
    """The inputs and outputs of a network.

    route: whether the predicted route is an input. rotation: whether r is predicted. part: "route", "pose" or "base".
    """

    route: bool = False
    rotation: bool = False
    part: str = "route"


KINDS = {
    "route": Kind(rotation=True),
    "route_t": Kind(),
    "pose": Kind(route=True, part="pose"),
    "pose_r": Kind(part="pose"),
    "pose_rt": Kind(rotation=True, part="pose"),
    "base": Kind(rotation=True, part="base"),
}
NAMES = tuple(f"paper_{kind}{blind}" for kind in KINDS for blind in ("", "_blind"))


def parse(name: str) -> tuple[Kind, bool]:
    """Return the kind of a network in NAMES, and whether it sees the scene."""
    own = name.removeprefix("paper_")
    return KINDS[own.removesuffix("_blind")], not own.endswith("_blind")


def network(name: str) -> WindowNet:
    """Return an untrained network in NAMES."""
    kind, scene = parse(name)
    if kind.part == "route":
        return window_net.route_net(kind.rotation, scene)
    if kind.part == "pose":
        return window_net.pose_net(kind.rotation, kind.route, scene)
    return window_net.base_net(scene)


def numbers(kind: Kind, batch: Windows, prior: PosePrior) -> tuple[torch.Tensor, torch.Tensor]:
    """Return the numbers (B, T, E) that describe a network's ends, and those that it predicts (B, T, O)."""
    pose = batch.pose if batch.pose is not None else prior.encode(batch.turns)[0]
    if kind.part == "route":
        return batch.route, batch.route if kind.rotation else batch.route[..., :TRANSLATION]
    body = torch.cat([pose, batch.hands], -1)
    if kind.part == "base":
        body = torch.cat([batch.route, body], -1)
    elif kind.rotation:
        body = torch.cat([batch.route[..., TRANSLATION:], body], -1)
    return body, body


class PaperLearner(Learner):
    """The training of a network of table 1. route: the trained RouteNet, for a PoseNet with routes as input."""

    def __init__(
        self, name: str, data: LongTermData, prior: PosePrior, scene: PointEncoder | None,
        route: WindowNet | None = None, batch: int = 0,
    ) -> None:  # fmt: skip
        self.kind, self.sees = parse(name)
        batch = batch or (32 if self.kind.part == "route" else 16)
        super().__init__(
            f"long_term_{name}",
            with_pretrained_scene(network(name), scene if self.sees else None),
            data,
            batch,
        )
        self.prior, self.route = prior, route

    def losses(self, done: float) -> dict[str, torch.Tensor]:
        batch = self.data.draw_windows(FRAMES, self.batch)
        cloud = self.data.cloud(batch, windows.POINTS) if self.sees else None
        with torch.no_grad():
            ends, wanted = numbers(self.kind, batch, self.prior)
            given = self.route(batch.route[:, 0], batch.route[:, -1], cloud) if self.kind.route else None
        made = self.net(ends[:, 0], ends[:, -1], cloud, given)
        error = (made - wanted[:, 1:-1]).abs()
        weight = torch.ones(error.shape[-1], device=error.device)
        if self.kind.part != "route":
            weight[-(wanted.shape[-1] - self._before_hands) :] = HANDS_WEIGHT
        return {"loss": (error * weight).sum(-1).mean(), "l1": error.mean()}

    @property
    def _before_hands(self) -> int:
        rotation = ROTATION if self.kind.rotation and self.kind.part == "pose" else 0
        return POSE + rotation + (PLACE if self.kind.part == "base" else 0)
