"""Trained networks as rows of the tables: the shipped ones, and those of the paper's table 1."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import torch

from ....models import weights
from ....models.long_term import gait, layout
from ....models.long_term.guided_pose import SIX, GuidedPose
from ....models.long_term.guided_route import GuidedRoute
from ....models.long_term.layout import HANDS, POSE, ROTATION, TRANSLATION
from ....models.long_term.pose_prior import PosePrior
from ....models.long_term.sub_goal_net import SubGoalNet
from ....models.long_term.window_net import WindowNet
from ..data import LongTermData, Windows
from ..stages import paper
from ..stages.learner import trained
from ..stages.route import no_noise
from ..stages.windows import pose_ends, route_ends
from .baselines import NearestWindow, RouteAndBodies, captured, interpolated
from .predicted import Predicted, with_ends

Predict = Callable[[Windows, torch.Tensor], Predicted]


@dataclass(frozen=True)
class Row:
    """A row of the tables. scene: whether the method sees the scene, None where not applicable."""

    name: str
    scene: bool | None
    predict: Predict


class Guided:
    """The shipped RouteNet and PoseNet, without noise, for the length of the captured window."""

    def __init__(self, route: GuidedRoute, pose: GuidedPose) -> None:
        self.route, self.pose = route, pose

    def __call__(self, windows: Windows, cloud: torch.Tensor) -> Predicted:
        ends, frames = route_ends(windows), windows.route.shape[1]
        z = no_noise(len(cloud), cloud.device)
        route = self.route(ends, frames, cloud, z)
        total = gait.advance(ends.start_gait, ends.end_gait, ends.length)
        planned = gait.planned(ends.start_gait, total, route)
        poses = self.pose(pose_ends(windows), route, planned, cloud, z)
        turns = layout.matrix_from_six(poses[..., :SIX].unflatten(-1, (layout.JOINTS, 6)))
        return Predicted(route, turns)


class OfThePaper:
    """RouteNet and PoseNet of the paper, or one of its ablations."""

    def __init__(self, route: WindowNet, pose: WindowNet, kind: paper.Kind, prior: PosePrior) -> None:
        self.route, self.pose, self.kind, self.prior = route, pose, kind, prior

    def __call__(self, windows: Windows, cloud: torch.Tensor) -> Predicted:
        route = self.route(windows.route[:, 0], windows.route[:, -1], cloud)
        ends, _ = paper.numbers(self.kind, windows, self.prior)
        made = self.pose(ends[:, 0], ends[:, -1], cloud, route if self.kind.route else None)
        if self.kind.rotation:  # RouteNet predicts only t
            route, made = torch.cat([route, made[..., :ROTATION]], -1), made[..., ROTATION:]
        return with_ends(windows, route, self.prior.decode(made[..., :POSE]))


class Base:
    """BaseNet."""

    def __init__(self, net: WindowNet, prior: PosePrior) -> None:
        self.net, self.prior = net, prior

    def __call__(self, windows: Windows, cloud: torch.Tensor) -> Predicted:
        ends, _ = paper.numbers(paper.KINDS["base"], windows, self.prior)
        route, pose, _ = self.net(ends[:, 0], ends[:, -1], cloud).split(
            [TRANSLATION + ROTATION, POSE, HANDS], dim=-1
        )
        return with_ends(windows, route, self.prior.decode(pose))


PAIRS = {
    "RouteNet(t)+PoseNet": ("paper_route_t", "paper_pose_rt"),
    "RouteNet(t+r)+PoseNet": ("paper_route", "paper_pose_r"),
    "ours, as in the paper": ("paper_route", "paper_pose"),
}


def rows(folder: Path, bank: LongTermData | None, device: torch.device) -> list[Row]:
    """Return the rows whose weights are in a folder, and the nearest window if a training set is given."""
    has = lambda *names: all(weights.weights_path(f"long_term_{name}", folder).exists() for name in names)
    load = lambda name, net: trained(f"long_term_{name}", net, folder, device)
    prior = load("prior", PosePrior())
    net = lambda name: load(name, paper.network(name))
    found: list[Row] = []
    for name, (route, pose) in PAIRS.items():
        for blind in ("_blind", ""):
            if has(route + blind, pose + blind):
                kind, scene = paper.parse(pose + blind)
                found.append(Row(name, scene, OfThePaper(net(route + blind), net(pose + blind), kind, prior)))
    for blind in ("_blind", ""):
        if has(f"paper_base{blind}"):
            found.append(Row("BaseNet", not blind, Base(net(f"paper_base{blind}"), prior)))
    if has("paper_route", "sub_goal"):
        bodies = load("sub_goal", SubGoalNet())
        found.append(Row("Route+CVAE", True, RouteAndBodies(net("paper_route"), bodies, prior)))
    if bank is not None:
        found.append(Row("HSNMS", False, NearestWindow(bank)))
    found.append(Row("interpolation", False, interpolated))
    if has("route", "pose"):
        found.append(Row("ours", True, Guided(load("route", GuidedRoute()), load("pose", GuidedPose()))))
    return [*found, Row("captured", None, captured)]
