"""The state in which a rollout starts: standing still, or continuing a motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch

from .....models import state
from .... import rotation, skeleton
from ....motion import Motion

SPAN = state.NOW * state.SAMPLE_STRIDE + 1  # frames of the past that the state contains
STANDING = (0.0, 0.0, 0.0, 1.0, 1.0)  # contacts


@dataclass
class Start:
    """The past of one take: network frame, metres, floor at height 0.

    joints (22, 3); matrices (22, 3, 3) global; velocities (22, 3) m/s; contacts (5,); roots (31, 3) and actions
    (31, 5) of the last second, oldest first.
    """

    joints: torch.Tensor
    matrices: torch.Tensor
    velocities: torch.Tensor
    contacts: torch.Tensor
    roots: torch.Tensor
    actions: torch.Tensor

    @classmethod
    def standing(cls, height: float, rotations: np.ndarray, root: np.ndarray) -> Start:
        """Return a start that stands still.

        height: of the pelvis. rotations: (22, 4) local quaternions. root: x, z and yaw.
        """
        place = np.array([root[0], height, root[1]])
        joints, _ = skeleton.forward_kinematics(place[None], rotations[None], skeleton.default_rest_joints())
        # Start poses have any heading: it is turned to the root's.
        turn = root[2] - float(state.heading_yaw(torch.as_tensor(joints))[0])
        turned = rotations.copy()
        turned[0] = rotation.multiply(rotation.about_y(turn), rotations[0])
        joints, matrices = _pose(place[None], turned[None])
        idle = torch.eye(state.ACTIONS)[0]
        return cls(
            joints[0], matrices[0], torch.zeros_like(joints[0]), torch.tensor(STANDING),
            _tensor(root).repeat(SPAN, 1), idle.repeat(SPAN, 1),
        )  # fmt: skip

    @classmethod
    def after(cls, motion: Motion, floor: float = 0.0) -> Start:
        """Return a start that continues a motion of 30 fps over a floor at this height.

        Raises ValueError where the motion has another rate, or no actions or contacts.
        """
        if motion.actions is None or motion.contacts is None or motion.fps != state.FPS:
            raise ValueError("a motion can be continued only with actions and contacts, at 30 fps")
        last = np.clip(np.arange(-SPAN, 0) + len(motion), 0, None)
        root = motion.root[last] - np.array([0.0, floor, 0.0])
        joints, matrices = _pose(root, motion.rotations[last])
        roots = torch.stack([joints[:, 0, 0], joints[:, 0, 2], state.heading_yaw(joints)], -1)
        velocity = (joints[-1] - joints[-2]) * state.FPS
        return cls(
            joints[-1],
            matrices[-1],
            velocity,
            _tensor(motion.contacts[-1]),
            roots,
            _tensor(motion.actions[last]),
        )


def _pose(root: np.ndarray, rotations: np.ndarray) -> tuple[torch.Tensor, torch.Tensor]:
    """Return joints (T, 22, 3) and global matrices (T, 22, 3, 3) of the default skeleton."""
    joints, quats = skeleton.forward_kinematics(
        root, rotations[:, : state.JOINTS], skeleton.default_rest_joints()
    )
    return _tensor(joints[:, : state.JOINTS]), _tensor(
        rotation.quaternion_to_matrix(quats[:, : state.JOINTS])
    )


def _tensor(values: np.ndarray) -> torch.Tensor:
    return torch.as_tensor(np.asarray(values), dtype=torch.float32)
