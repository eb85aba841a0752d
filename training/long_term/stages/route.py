"""Train the shipped RouteNet: L1 of positions and rotations (equation 3) and of velocities, noise, durations."""

from __future__ import annotations

import torch

from ....models.long_term.guided_net import LATENT
from ....models.long_term.guided_route import FPS, GuidedRoute
from ....models.long_term.layers import divergence, sample
from ....models.long_term.point_net import PointEncoder
from ..data import LongTermData
from . import windows
from .learner import Learner, with_pretrained_scene

KL_WEIGHT = 0.01
SPEED_WEIGHT = 0.1  # per metre per second
SECONDS_WEIGHT = 0.2


class RouteLearner(Learner):
    """The training of RouteNet. scene: the pretrained encoder of point clouds."""

    def __init__(self, data: LongTermData, scene: PointEncoder | None, batch: int = 32) -> None:
        super().__init__("long_term_route", with_pretrained_scene(GuidedRoute(), scene), data, batch)

    def losses(self, done: float) -> dict[str, torch.Tensor]:
        length = windows.draw_length(self.data)
        batch = self.data.draw_windows(length, self.batch)
        cloud, ends, route = self.data.cloud(batch, windows.POINTS), windows.route_ends(batch), batch.route
        mean, log_variance = self.net.posterior(ends, route)
        z = sample(mean, log_variance)
        z = torch.where(torch.rand(len(z), 1, device=z.device) < windows.PRIOR_SHARE, torch.randn_like(z), z)
        made = self.net(ends, length, cloud, z)
        place = (made - route)[..., :3].abs().sum(-1).mean()
        turn = (made - route)[..., 3:].abs().sum(-1).mean()
        speed = torch.diff(made - route, dim=1).abs().sum(-1).mean() * FPS
        kl = divergence(mean, log_variance, windows.FREE)
        seconds = (self.net.seconds(ends).log() - torch.tensor((length - 1) / FPS).log()).abs().mean()
        loss = place + turn + SPEED_WEIGHT * speed + KL_WEIGHT * kl + SECONDS_WEIGHT * seconds
        return {"loss": loss, "t": place, "r": turn, "speed": speed, "kl": kl, "seconds": seconds}


def no_noise(count: int, device: torch.device) -> torch.Tensor:
    """Return zero noise (B, 8), the mode of the prior."""
    return torch.zeros(count, LATENT, device=device)
