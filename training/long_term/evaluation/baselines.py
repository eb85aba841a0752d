"""Baselines of the tables: interpolation, the nearest window of the training set (HSNMS), Route+CVAE.

Each is a function of windows and their clouds (B, N, 3) that returns Predicted.
"""

from __future__ import annotations

import numpy as np
import torch

from ....models.long_term import layout
from ....models.long_term.pose_prior import PosePrior
from ....models.long_term.sub_goal_net import ACTIONS, LATENT, SubGoalNet
from ....models.long_term.window_net import WindowNet
from ....samp_addon import rotation
from ..data import LongTermData, Windows
from .predicted import Predicted, figures, truth, with_ends

BANK_CHUNK = 256
END_WEIGHT = (
    5.0  # weight of the distance between the ends' positions, relative to the mean distance of joints
)


def interpolated(windows: Windows, cloud: torch.Tensor | None = None) -> Predicted:
    """Return a straight line and slerp of every joint; not in the paper's tables."""
    frames = windows.route.shape[1]
    share = torch.linspace(0, 1, frames, device=windows.route.device)
    ends = windows.route[:, [0, -1], :3]
    place = ends[:, :1] + share[None, :, None] * (ends[:, 1:] - ends[:, :1])
    whole = torch.cat([layout.matrix_from_six(windows.route[..., 3:])[:, :, None], windows.turns], 2)
    turned = _slerp(whole[:, :1], whole[:, -1:], share[None, :, None])
    return Predicted(torch.cat([place, layout.six_from_matrix(turned[:, :, 0])], -1), turned[:, :, 1:])


def _slerp(start: torch.Tensor, end: torch.Tensor, share: torch.Tensor) -> torch.Tensor:
    """Return rotation matrices (B, T, J, 3, 3) interpolated between two (B, 1, J, 3, 3), at shares (1, T, 1)."""
    q = [rotation.matrix_to_quaternion(m.double().cpu().numpy()) for m in (start, end)]
    frames = share.shape[1]
    both = [np.broadcast_to(v, (v.shape[0], frames, *v.shape[2:])) for v in q]
    mixed = rotation.slerp(*both, np.broadcast_to(share.double().cpu().numpy(), both[0].shape[:-1]))
    return torch.as_tensor(rotation.quaternion_to_matrix(mixed), dtype=start.dtype, device=start.device)


class NearestWindow:
    """HSNMS: the window of a memory bank with the most similar ends, warped to meet the given ends."""

    def __init__(self, bank: LongTermData, length: int = layout.FRAMES) -> None:
        self.bank, self.rows = bank, bank.rows[length]
        parts = [self._features(bank, bank.window_batch(rows)) for rows in self.rows.split(BANK_CHUNK)]
        self.features = torch.cat(parts)

    def __call__(self, windows: Windows, cloud: torch.Tensor | None = None) -> Predicted:
        wanted = self._features(self.bank, windows)
        found = self.bank.window_batch(self.rows[torch.cdist(wanted, self.features).argmin(1)])
        frames = windows.route.shape[1]
        share = torch.linspace(0, 1, frames, device=windows.route.device)
        off = windows.route[:, [0, -1], :3] - found.route[:, [0, -1], :3]
        place = found.route[..., :3] + off[:, :1] + share[None, :, None] * (off[:, 1:] - off[:, :1])
        own, wants = (
            torch.cat([layout.matrix_from_six(w.route[..., 3:])[:, :, None], w.turns], 2)
            for w in (found, windows)
        )
        bend = [wants[:, k] @ own[:, k].transpose(-1, -2) for k in (0, -1)]
        turned = _slerp(bend[0][:, None], bend[1][:, None], share[None, :, None]) @ own
        return Predicted(torch.cat([place, layout.six_from_matrix(turned[:, :, 0])], -1), turned[:, :, 1:])

    @staticmethod
    def _features(data: LongTermData, windows: Windows) -> torch.Tensor:
        """Return features (B, F): joints of both ends relative to their pelvis, and the goal's position."""
        ends = Predicted(windows.route[:, [0, -1]], windows.turns[:, [0, -1]])
        joints = figures(data, ends, torch.zeros_like(windows.betas))[0]
        about = (joints - joints[:, :, :1]).flatten(1) / np.sqrt(joints.shape[2])
        return torch.cat([about, END_WEIGHT * windows.route[:, -1, :3]], -1)


class RouteAndBodies:
    """Route+CVAE: RouteNet's route, and in each frame a body of the sub-goal network, with the same z in all."""

    def __init__(self, route: WindowNet, bodies: SubGoalNet, prior: PosePrior) -> None:
        self.route, self.bodies, self.prior = route, bodies, prior

    def __call__(self, windows: Windows, cloud: torch.Tensor) -> Predicted:
        made = self.route(windows.route[:, 0], windows.route[:, -1], cloud)
        z = torch.randn(len(made), LATENT, device=made.device)
        turns = [self._bodies(windows, made[:, k], cloud, z) for k in range(made.shape[1])]
        return with_ends(windows, made, torch.stack(turns, 1))

    def _bodies(
        self, windows: Windows, route: torch.Tensor, cloud: torch.Tensor, z: torch.Tensor
    ) -> torch.Tensor:
        """Return local rotations (B, 21, 3, 3) of bodies at (B, 9) of a route."""
        pelvis = layout.matrix_from_six(route[:, 3:])
        back = layout.about_y(-layout.yaw_of(pelvis))
        origin = route[:, :3] * route.new_tensor([1.0, 0.0, 1.0])
        given = torch.zeros_like(route)
        given[:, 1] = route[:, 1]
        given[:, 3:] = layout.six_from_matrix(back @ pelvis)
        seen = (cloud - origin[:, None]) @ back.transpose(1, 2)
        still = torch.zeros(len(route), layout.PHASE, device=route.device)
        unknown = torch.zeros(len(route), len(ACTIONS), device=route.device)
        condition = self.bodies.condition(seen, windows.betas, given, still, unknown)
        return self.prior.decode(layout.split_body(self.bodies.decode(condition, given, z))[2])


def captured(windows: Windows, cloud: torch.Tensor | None = None) -> Predicted:
    """Return the captured motion itself."""
    return truth(windows)
