"""Train the shipped PoseNet: L1 of rotations and hands (equation 4), of joints and their velocities, foot slide.

It is trained on the routes predicted by RouteNet, whose weights are fixed (section 3.3).
"""

from __future__ import annotations

import torch

from ....models.long_term import layout
from ....models.long_term.guided_pose import SIX, GuidedPose
from ....models.long_term.guided_route import FPS, GuidedRoute
from ....models.long_term.layers import divergence, sample
from ....models.long_term.point_net import PointEncoder
from ....samp_addon.skeleton import INDEX
from ..data import LongTermData, Windows
from . import windows
from .learner import Learner, with_pretrained_scene

KL_WEIGHT = 0.01
HANDS_WEIGHT = 0.1
JOINTS_WEIGHT = 4.0  # per metre
SPEED_WEIGHT = 0.1  # per metre per second
FEET_WEIGHT = 0.1  # per metre per second
SOLES = [[INDEX[f"{side}_{part}"] for part in ("ankle", "foot")] for side in ("left", "right")]


class PoseLearner(Learner):
    """The training of PoseNet. route: the trained RouteNet. scene: the pretrained encoder of point clouds."""

    def __init__(
        self, data: LongTermData, route: GuidedRoute, scene: PointEncoder | None, batch: int = 16
    ) -> None:
        super().__init__("long_term_pose", with_pretrained_scene(GuidedPose(), scene), data, batch)
        self.route = route

    def losses(self, done: float) -> dict[str, torch.Tensor]:
        batch = self.data.draw_windows(windows.draw_length(self.data), self.batch)
        cloud = self.data.cloud(batch, windows.POINTS)
        route = self._route(batch, cloud)
        gait, ends, true = windows.planned_gait(batch, route), windows.pose_ends(batch), windows.poses(batch)
        mean, log_variance = self.net.posterior(ends, route, gait, true)
        z = sample(mean, log_variance)
        z = torch.where(torch.rand(len(z), 1, device=z.device) < windows.PRIOR_SHARE, torch.randn_like(z), z)
        made = self.net(ends, route, gait, cloud, z)
        pose = (made - true)[..., :SIX].abs().mean()
        hands = (made - true)[..., SIX:].abs().mean()
        parts = self._joints(batch, route, made)
        kl = divergence(mean, log_variance, windows.FREE)
        loss = 10 * pose + HANDS_WEIGHT * hands + KL_WEIGHT * kl + JOINTS_WEIGHT * parts["joints"]
        loss = loss + SPEED_WEIGHT * parts["speed"] + FEET_WEIGHT * parts["feet"]
        return {"loss": loss, "pose": pose, "hands": hands, **parts, "kl": kl}

    @torch.no_grad()
    def _route(self, batch: Windows, cloud: torch.Tensor) -> torch.Tensor:
        """Return RouteNet's route, with noise from the posterior of the true route."""
        ends = windows.route_ends(batch)
        z = sample(*self.route.posterior(ends, batch.route))
        return self.route(ends, batch.route.shape[1], cloud, z)

    def _joints(self, batch: Windows, route: torch.Tensor, made: torch.Tensor) -> dict[str, torch.Tensor]:
        """Return errors of joints relative to the pelvis, metres, of their speed, and the slide of feet in contact."""
        model, frames = self.data.model, route.shape[1]
        rest = model.rest_joints(batch.betas).repeat_interleave(frames, 0)
        turns = layout.matrix_from_six(made[..., :SIX].unflatten(-1, (layout.JOINTS, 6))).flatten(0, 1)
        pelvis = layout.matrix_from_six(route[..., 3:]).flatten(0, 1)[:, None]
        still = torch.zeros_like(rest[:, 0])
        own = model.joints(still, torch.cat([pelvis, turns], 1), rest)[0].unflatten(0, (-1, frames))
        with torch.no_grad():
            known = layout.matrix_from_six(batch.route[..., 3:]).flatten(0, 1)[:, None]
            true = model.joints(still, torch.cat([known, batch.turns.flatten(0, 1)], 1), rest)[0]
            true = true.unflatten(0, (-1, frames))
        joints = (own - true).norm(dim=-1).mean()
        speed = (torch.diff(own - true, dim=1) * FPS).norm(dim=-1).mean()
        return {"joints": joints, "speed": speed, "feet": self._slide(batch, own + route[:, :, None, :3])}

    @staticmethod
    def _slide(batch: Windows, joints: torch.Tensor) -> torch.Tensor:
        """Return the mean speed, metres per second, of feet in contact in two consecutive frames."""
        holds = batch.feet[:, 1:] * batch.feet[:, :-1]
        speed = (torch.diff(joints, dim=1) * FPS).norm(dim=-1)
        feet = torch.stack([speed[..., side].amin(-1) for side in SOLES], -1)
        return (feet * holds).sum() / holds.sum().clamp(min=1)
