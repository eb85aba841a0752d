"""States and targets of all frames of a training set, computed on the training device."""

from __future__ import annotations

import math

import numpy as np
import torch

from .....models import state
from .....samp_addon import skeleton

SMOOTH_PATH = 10.0
"""Standard deviation, frames, of the filter over the planned path. The sway of the true future path reveals when each
foot comes down; at run time nothing does, and legs trained on the sway come to rest."""
REACH = 40  # frames of the filter on each side
CHUNK = 1 << 15  # frames encoded per batch


def matrices(quats: torch.Tensor) -> torch.Tensor:
    """Return rotation matrices (..., 3, 3) of unit quaternions (..., 4)."""
    w, x, y, z = quats.unbind(-1)
    rows = (
        1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
    )  # fmt: skip
    return torch.stack(rows, -1).unflatten(-1, (3, 3))


def forward_kinematics(root: torch.Tensor, quats: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Return world joints (N, 22, 3) and global matrices (N, 22, 3, 3).

    root: (N, 3) pelvis. quats: (N, 22, 4) local rotations.
    """
    rest = torch.as_tensor(skeleton.default_rest_joints()[: state.JOINTS].copy(), dtype=root.dtype)
    rest = rest.to(root.device)
    local = matrices(torch.nn.functional.normalize(quats, dim=-1))
    joints, turned = [root], [local[:, 0]]
    for j in range(1, state.JOINTS):
        above = int(skeleton.PARENTS[j])
        joints.append(joints[above] + turned[above] @ (rest[j] - rest[above]))
        turned.append(turned[above] @ local[:, j])
    return torch.stack(joints, 1), torch.stack(turned, 1)


class Encoder:
    """Encoder of the frames of concatenated sequences.

    root (N, 3), quats (N, 22, 4), actions (N, 5), contacts (N, 5), goal (N, 6), goal_action (N,), first and last
    frame (N,) of the sequence of each frame.
    """

    def __init__(
        self,
        root: torch.Tensor,
        quats: torch.Tensor,
        actions: torch.Tensor,
        contacts: torch.Tensor,
        goal: torch.Tensor,
        goal_action: torch.Tensor,
        first: torch.Tensor,
        last: torch.Tensor,
    ) -> None:
        self.root, self.quats, self.actions, self.contacts = root, quats, actions, contacts
        self.goals = torch.cat([goal, torch.eye(state.ACTIONS, device=goal.device)[goal_action]], -1)
        self.first, self.last = first, last
        self.roots = torch.cat([self._roots(part) for part in self._chunks()])
        self.planned = self._smooth_path()

    def _chunks(self) -> list[torch.Tensor]:
        return list(torch.arange(len(self.root), device=self.root.device).split(CHUNK))

    def _pose(self, frames: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        return forward_kinematics(self.root[frames], self.quats[frames].float())

    def _roots(self, frames: torch.Tensor) -> torch.Tensor:
        joints, _ = self._pose(frames)
        return torch.cat([joints[:, 0, [0, 2]], state.heading_yaw(joints)[:, None]], -1)

    def _clamp_to_sequence(self, frames: torch.Tensor, of: torch.Tensor) -> torch.Tensor:
        """Clamp frames (N, ...) to the sequences of the frames ``of`` (N,)."""
        shape = (-1,) + (1,) * (frames.dim() - 1)
        return frames.clamp(self.first[of].reshape(shape), self.last[of].reshape(shape))

    def _smooth_path(self) -> torch.Tensor:
        """Return roots (N, 3) without the sway of single steps, smoothed within each sequence."""
        turns = torch.diff(self.roots[:, 2].double(), prepend=self.roots[:1, 2].double())
        turns = torch.remainder(turns + math.pi, 2 * math.pi) - math.pi
        path = torch.cat([self.roots[:, :2].double(), (self.roots[0, 2] + turns.cumsum(0))[:, None]], -1)
        offsets = np.arange(-REACH, REACH + 1)
        kernel = np.exp(-0.5 * (offsets / SMOOTH_PATH) ** 2)
        now = torch.arange(len(path), device=path.device)
        smooth = torch.zeros_like(path)
        for offset, weight in zip(offsets, kernel / kernel.sum(), strict=True):
            smooth += float(weight) * path[self._clamp_to_sequence(now + int(offset), now)]
        return smooth.float()

    def encode(self, dtype: torch.dtype = torch.float16) -> tuple[torch.Tensor, torch.Tensor]:
        """Return states (N, 647) and targets (N, 647).

        A target is the next frame in the root frame of the present one; the last frame of a sequence is repeated.
        """
        states, targets = [], []
        for frames in self._chunks():
            states.append(self._assemble(frames, frames).to(dtype))
            targets.append(self._assemble(self._clamp_to_sequence(frames + 1, frames), frames).to(dtype))
        return torch.cat(states), torch.cat(targets)

    def _assemble(self, frames: torch.Tensor, reference: torch.Tensor) -> torch.Tensor:
        offsets = torch.as_tensor(state.SAMPLE_OFFSETS, device=frames.device)
        window = self._clamp_to_sequence(frames[:, None] + offsets, frames)
        # At run time, future goals are unknown and assumed to stay the present one.
        known = torch.minimum(window, reference[:, None])
        path = torch.where((offsets > 0)[:, None], self.planned[window], self.roots[window])
        ahead = self.planned[self._clamp_to_sequence(frames + state.FPS, frames)]
        joints, turned = self._pose(frames)
        before = self._clamp_to_sequence(frames - 1, frames)
        after = torch.where(before == frames, self._clamp_to_sequence(frames + 1, frames), frames)
        velocity = (
            self._pose(after)[0] - self._pose(self._clamp_to_sequence(after - 1, frames))[0]
        ) * state.FPS
        axes = torch.stack([turned[..., 2], turned[..., 1]], -2)
        return state.assemble(
            self.roots[reference], joints, axes, velocity, ahead, path,
            self.actions[window].float(), self.contacts[frames].float(), self.goals[reference, :6],
            self.goals[known],
        )  # fmt: skip
