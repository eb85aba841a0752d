"""Codes of real motion, from which the held components of z are drawn at run time."""

from __future__ import annotations

import copy

import torch

from .....models.motion_net import STYLES, MotionNet
from .frames import Frames


@torch.no_grad()
def store(net: MotionNet, average: dict[str, torch.Tensor], frames: Frames) -> None:
    """Encode random frames of each action with the averaged weights, and store the codes in ``net``.

    Drawn codes are distributed as those of real motion, so that the KL divergence of the held components, which makes
    the network ignore them, needs hardly any weight in training.
    """
    encoder = copy.deepcopy(net)
    encoder.load_state_dict(net.state_dict() | average)
    held = int(net.held)
    for action in range(len(net.style_codes)):
        rows = frames.sample_frames(action, STYLES)
        if not len(rows):
            continue
        known = torch.ones_like(rows, dtype=torch.bool)
        features = frames.object_features(rows, frames.roots[rows], torch.zeros_like(rows), known)
        x, y = frames.states[rows].float(), frames.targets[rows].float()
        mean, log_variance = encoder.encode(
            (x - net.input_mean) / net.input_std, encoder.change(y, x), encoder.normalised_object(features)
        )
        codes = mean + torch.exp(0.5 * log_variance) * torch.randn_like(mean)
        net.style_codes[action, :, :held] = codes[:, :held]
