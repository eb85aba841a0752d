"""Train the pose prior: joints within 1.5 cm after encoding and decoding, codes close to a standard Gaussian."""

from __future__ import annotations

from pathlib import Path

import torch

from ....models.long_term.layers import divergence
from ....models.long_term.pose_prior import PosePrior
from ..data import LongTermData, matrices
from .learner import Learner

KL_WEIGHT = 2e-4
JOINTS_WEIGHT = 10.0  # per metre, relative to matrix entries


class PriorLearner(Learner):
    """The training of the prior on poses of single frames; half of the batches are mirrored."""

    def __init__(self, data: LongTermData, batch: int = 256) -> None:
        super().__init__("long_term_prior", PosePrior(), data, batch)

    def begin_with(self, folder: Path) -> None:
        """Load the encoder and the decoder of another training. The encoder is fixed, so that codes keep their meaning
        for networks that were trained on them; the last layer of the decoder begins anew."""
        super().begin_with(folder)
        self.net.begin_at_rest()
        self.net.encoder.requires_grad_(False)
        self._restart_average()

    def losses(self, done: float) -> dict[str, torch.Tensor]:
        data = self.data
        rows = torch.randint(len(data), (self.batch,), device=data.device)
        quats = data.quats[rows]
        if torch.rand(()) < 0.5:
            quats = data.mirrored(quats)
        turns = matrices(quats)[:, 1:]
        made, mean, log_variance = self.net(turns)
        error = joint_error(data, made, turns)
        kl = divergence(mean, log_variance)
        rotation = (made - turns).abs().mean()
        return {"loss": rotation + JOINTS_WEIGHT * error + KL_WEIGHT * kl, "joints_cm": 100 * error, "kl": kl}


def joint_error(data: LongTermData, made: torch.Tensor, turns: torch.Tensor) -> torch.Tensor:
    """Return the mean distance of joints, metres, of local rotations (B, 21, 3, 3) of the default body."""
    count = len(turns)
    rest = data.model.rest_joints(torch.zeros(count, data.betas.shape[1], device=data.device))
    root, pelvis = rest[:, 0], torch.eye(3, device=data.device).expand(count, 1, 3, 3)
    places = [data.model.joints(root, torch.cat([pelvis, t], 1), rest)[0] for t in (made, turns)]
    return (places[0] - places[1]).norm(dim=-1).mean()
