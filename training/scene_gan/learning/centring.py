"""Move the mean error of the pose generator into its last bias.

The 6-D numbers of a joint can turn about its bone once around within a few frames: that moves no joint, so that errors
of positions do not see it, and gradients of rotations undo it slowly. Such turns are alike in all windows.
"""

from __future__ import annotations

import torch

from ....models.scene_gan import kinematics
from ....models.scene_gan.generators import PoseGenerator
from ..data.dataset import Batch

ROUNDS = 3
EDGE = 0.98
"""Largest tanh that is inverted."""


@torch.no_grad()
def centre(
    pose: PoseGenerator, batches: list[Batch], scenes: list[torch.Tensor], draws: torch.Generator | None
) -> None:
    """Add the median error over some batches, in the cosines of the dense part, to the last bias of ``pose``.

    scenes: features (B, scene) of each batch. Errors are those of the numbers before the tanh, on true trajectories.
    """
    inverse = torch.linalg.pinv(pose.rough.cosines)
    for _ in range(ROUNDS):
        missing = 0.0
        for batch, scene in zip(batches, scenes, strict=True):
            noise = pose.latent.draw(len(scene), draws)
            made = pose(noise, scene, batch.start, batch.motions.velocities)
            true = batch.motions.six[:, 1:]
            before = [
                torch.atanh(((six - batch.start.six[:, None]) / kinematics.LIMIT).clamp(-EDGE, EDGE))
                for six in (made, true)
            ]
            missing = missing + (before[1] - before[0]).median(0).values / len(batches)
        # (64, 22, 6) over time to the cosines of each number.
        pose.rough.last.bias.add_((missing.permute(1, 2, 0) @ inverse).reshape(-1))
