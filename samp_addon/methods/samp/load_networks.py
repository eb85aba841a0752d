"""The trained networks of SAMP, loaded once for each version of their weights.

A file that is replaced in the same process, as after a training, is loaded again: see models.weights.file_version.
"""

from __future__ import annotations

import functools
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from ...errors import SampError
from .. import start_poses

if TYPE_CHECKING:
    import torch

    from ....models.goal_net import GoalNet
    from ....models.motion_net import MotionNet

CACHED = 4
"""Versions of each network that stay in memory, so that several can be compared."""


class MotionNetwork(NamedTuple):
    """MotionNet in evaluation mode without its encoder, and the start poses that are stored with its weights.

    start_heights: (K,) of the pelvis over the floor, metres. start_rotations: (K, 22, 4) local quaternions w, x, y, z.
    """

    net: MotionNet
    start_heights: torch.Tensor
    start_rotations: torch.Tensor


def load_motion_net(folder: Path | None = None, kind: str = "motion_net") -> MotionNetwork:
    """Return MotionNet with its start poses; shared, do not modify.

    folder: of other weights than the shipped ones. kind: one of models.baselines.NETWORKS. Raises SampError for a file
    that is missing, damaged or does not fit the network.
    """
    from ....models import weights

    try:
        return _motion_net(folder, kind, weights.file_version("motion_net", folder))
    except weights.WeightsError as error:
        raise SampError(str(error)) from error


def load_goal_net(folder: Path | None = None) -> GoalNet:
    """Return GoalNet in evaluation mode; shared, do not modify. Arguments and errors as load_motion_net."""
    from ....models import weights

    try:
        return _goal_net(folder, weights.file_version("goal_net", folder))
    except weights.WeightsError as error:
        raise SampError(str(error)) from error


@functools.lru_cache(maxsize=CACHED)
def _motion_net(folder: Path | None, kind: str, version: tuple[str, int, str]) -> MotionNetwork:
    """version: of the file, which only has to differ between contents."""
    import torch

    from ....models import baselines, weights

    path, network = weights.weights_path("motion_net", folder), baselines.NETWORKS[kind]
    # Tensors made in inference mode could not be used outside of it, whatever mode the first caller is in.
    with torch.inference_mode(False):
        tensors = weights.load_weights("motion_net", folder)
        try:
            start_heights, start_rotations = tensors.pop("start_heights"), tensors.pop("start_rotations")
            net = network(baselines.hidden_width(tensors), baselines.posture_count(tensors))
        except KeyError as error:
            raise weights.missing_tensor(error.args[0], path) from error
        net.drop_encoder()
        # Weights of earlier trainings may lack these.
        own = net.state_dict()
        for name in ("held", "goal_grid", "style_codes", "style_postures"):
            if name in own:
                tensors.setdefault(name, torch.zeros_like(own[name]))
        weights.fill(net, tensors, path)
        kept = torch.as_tensor(start_poses.usable(start_rotations.double().numpy()))
        return MotionNetwork(net.eval(), start_heights[kept].float(), start_rotations[kept].float())


@functools.lru_cache(maxsize=CACHED)
def _goal_net(folder: Path | None, version: tuple[str, int, str]) -> GoalNet:
    """version: as for _motion_net."""
    import torch

    from ....models import goal_net

    with torch.inference_mode(False):
        return goal_net.load(folder)
