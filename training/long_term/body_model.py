"""The default human in torch, for batches of bodies of different shapes: joints and a subset of the skin.

Hands are rigid here: their skin follows the wrists. Network frame, metres.
"""

from __future__ import annotations

import numpy as np
import torch

from ...samp_addon import skeleton
from ...samp_addon.body import betas, human

SKIN = 256
COUNT = skeleton.BODY_COUNT
RESTING = ("pelvis", "hip", "knee", "spine1", "spine2", "spine3", "head")
"""Joints whose skin at the back rests on furniture."""


class BodyModel:
    """Forward kinematics and skinning on a device.

    subset: vertex indices of the skin (V,). soles, rests: flags (V,) of vertices under the feet, and of those at the
    back that rest on furniture.
    """

    def __init__(self, device: torch.device | str = "cpu", skin: int = SKIN) -> None:
        body = human.load()
        shapes = [body.shapes[name] for name in betas.SHAPES]
        missing = betas.COUNT - len(shapes)
        collision = body.collision
        self.subset = collision[np.linspace(0, len(collision) - 1, min(skin, len(collision))).astype(int)]
        tensor = lambda values: torch.as_tensor(np.array(values), dtype=torch.float32, device=device)
        pad = lambda values: np.concatenate([values, np.zeros((missing, *values.shape[1:]))])
        self._joints = tensor(body.joints[:COUNT])
        self._joint_shapes = tensor(pad(np.stack([s[1][:COUNT] for s in shapes])))
        self._skin = tensor(body.vertices[self.subset])
        self._skin_shapes = tensor(pad(np.stack([s[0][self.subset] for s in shapes])))
        owners = _body_joints()[body.weight_joints[self.subset]]
        self._owners = torch.as_tensor(owners, device=device)
        self._weights = tensor(body.weights[self.subset])
        main = np.take_along_axis(owners, body.weights[self.subset].argmax(1)[:, None], 1)[:, 0]
        names = [name.split("_")[-1] for name in skeleton.BODY_JOINTS]
        behind = body.vertices[self.subset][:, 2] < body.joints[main][:, 2]
        self.soles = torch.as_tensor(body.vertices[self.subset][:, 1] < body.floor + 0.02, device=device)
        resting = np.isin(main, [j for j, name in enumerate(names) if name in RESTING]) & behind
        self.rests = torch.as_tensor(resting, device=device)

    def rest_joints(self, shape: torch.Tensor) -> torch.Tensor:
        """Return the rest joints (B, 22, 3) of betas (B, 10), pelvis at the origin."""
        return self._joints + torch.einsum("bk,kja->bja", shape, self._joint_shapes)

    def joints(
        self, root: torch.Tensor, rotations: torch.Tensor, rest: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Return positions (B, 22, 3) and global rotations (B, 22, 3, 3).

        root: (B, 3). rotations: local matrices (B, 22, 3, 3). rest: (B, 22, 3).
        """
        turned, placed = [rotations[:, 0]], [root]
        bones = rest - rest[:, np.maximum(skeleton.PARENTS[:COUNT], 0)]
        for j in range(1, COUNT):
            parent = int(skeleton.PARENTS[j])
            turned.append(turned[parent] @ rotations[:, j])
            placed.append(placed[parent] + (turned[parent] @ bones[:, j, :, None])[..., 0])
        return torch.stack(placed, 1), torch.stack(turned, 1)

    def skin(
        self, positions: torch.Tensor, globals_: torch.Tensor, rest: torch.Tensor, shape: torch.Tensor
    ) -> torch.Tensor:
        """Return the skin (B, V, 3) for the results of ``joints``. shape: betas (B, 10)."""
        points = self._skin + torch.einsum("bk,kva->bva", shape, self._skin_shapes)
        made = torch.zeros_like(points)
        for k in range(self._owners.shape[1]):
            owner = self._owners[:, k]
            local = points - rest[:, owner]
            moved = (globals_[:, owner] @ local[..., None])[..., 0] + positions[:, owner]
            made = made + self._weights[:, k, None] * moved
        return made


def _body_joints() -> np.ndarray:
    """Return, for each of the 55 joints, itself or its nearest ancestor among the body joints."""
    own = np.arange(len(skeleton.JOINTS))
    for j in range(COUNT, len(own)):
        own[j] = own[skeleton.PARENTS[j]]
    return own
