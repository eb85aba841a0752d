"""The initial condition of every window: the initial pose, its position in the view, and its velocity.

The paper's condition is the root-centred initial pose, on which the picture is centred. Here position and velocities
are added: the position contains the camera's distance, and velocities let a window continue the previous one.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch

from . import constants, kinematics

FPS = 30
JOINT, TURN, SPEED = 0.15, 0.15, 0.2
PELVIS_SPEED, PLACE, HEIGHT, CAMERA = 0.3, 1.0, 0.15, 0.15
STANDING = 0.9
"""What the numbers of a condition are divided by, so that each varies by about one in the data set: joints away from
the rest pose, metres; 6-D rotations; velocities of joints and of the pelvis, m/s; place and height of the pelvis,
metres, the latter from STANDING on; pitch, roll and lens of the camera. In metres, poses varied by a seventh of scene
and noise, and the generators hardly saw them."""

SIZE = kinematics.JOINTS * (3 + 6 + 3) + 3 + 3 + 1 + 3
"""Numbers of `condition`: joints x (position, 6-D rotation, velocity), root velocity, place, height, camera."""


@dataclass(frozen=True)
class Start:
    """First frames of B windows, in the view frame.

    six: (B, 22, 6) rotations. root: (B, 3) of the pelvis. rest: (B, 22, 3) rest joints. joint_velocity: (B, 22, 3)
    relative to the pelvis, metres per frame; root_velocity: (B, 3) of the pelvis. height: (B,) of the pelvis over the
    floor. camera: (B, 3, 4) from the view frame to camera coordinates (x right, y down, z forward). lens: (B, 3) focal
    length and principal point (x, y) in widths of the picture.
    """

    six: torch.Tensor
    root: torch.Tensor
    rest: torch.Tensor
    joint_velocity: torch.Tensor
    root_velocity: torch.Tensor
    height: torch.Tensor
    camera: torch.Tensor
    lens: torch.Tensor

    def __len__(self) -> int:
        return len(self.root)

    @property
    def positions(self) -> torch.Tensor:
        """Joint positions (B, 22, 3) relative to the pelvis."""
        return kinematics.joint_positions(kinematics.matrices(self.six), self.rest)

    def condition(self) -> torch.Tensor:
        """Return the numbers (B, SIZE) that are input to networks."""
        upright = constants.numbers((1.0, 0.0, 0.0, 0.0, 1.0, 0.0), self.six.device)
        per_joint = torch.cat(
            [
                (self.positions - (self.rest - self.rest[:, :1])) / JOINT,
                (self.six - upright) / TURN,
                self.joint_velocity * FPS / SPEED,
            ],
            dim=-1,
        ).flatten(1)
        pitch, roll = self.camera[:, 2, 1], self.camera[:, 0, 1]
        camera = torch.stack([pitch, roll, self.lens[:, 0] - 1.0], -1) / CAMERA
        return torch.cat(
            [
                per_joint,
                self.root_velocity * FPS / PELVIS_SPEED,
                self.root / PLACE,
                (self.height[:, None] - STANDING) / HEIGHT,
                camera,
            ],
            dim=-1,
        )

    def repeated(self, count: int) -> Start:
        """Return the windows with each one repeated ``count`` times."""
        return self.rows(torch.arange(len(self), device=self.root.device).repeat_interleave(count))

    def rows(self, rows: torch.Tensor) -> Start:
        """Return some of the windows."""
        return Start(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))
