"""Inputs of the critics: motion in the view frame, in the picture, and crops of the depth map (section 3.3)."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch.nn import functional

from . import constants, kinematics
from .start import Start

NEAREST = 0.3  # distance (m) to which nearer points are moved for projection
ASPECT = 9 / 16
REACH = 1.6
"""Half the width of a crop at the body's distance, metres. The paper's crops are (Hc / d, Wc / d), with Hc and Wc a
quarter of the picture in its unit of d; here Wc gives a crop of this width at every distance."""
EVERY = 8  # frames between crops: 9 in 65


@dataclass(frozen=True)
class Motions:
    """Windows of 65 frames, the given one and 64 more, in the view frame, metres.

    root: (B, 65, 3). six: (B, 65, 22, 6). positions: (B, 65, 22, 3) of the joints, relative to the pelvis.
    """

    root: torch.Tensor
    six: torch.Tensor
    positions: torch.Tensor

    @classmethod
    def of(cls, start: Start, velocities: torch.Tensor, six: torch.Tensor) -> Motions:
        """Return the windows of a start, velocities (B, 3, 64) and rotations (B, 64, 22, 6).

        X = P + R, where R_t is the sum of the velocities before t (section 3.2.1).
        """
        root = _way(start, velocities)
        every = torch.cat([start.six[:, None], six], dim=1)
        positions = kinematics.joint_positions(kinematics.matrices(every), start.rest[:, None])
        return cls(root, every, positions)

    @classmethod
    def moved(cls, start: Start, velocities: torch.Tensor) -> Motions:
        """Return the windows of a start that keeps its pose, for velocities (B, 3, 64)."""
        root = _way(start, velocities)
        still = lambda values: values[:, None].expand(-1, root.shape[1], -1, -1)
        return cls(root, still(start.six), still(start.positions))

    def rows(self, rows: torch.Tensor | slice) -> Motions:
        """Return some of the windows."""
        return Motions(self.root[rows], self.six[rows], self.positions[rows])

    @property
    def velocities(self) -> torch.Tensor:
        """Velocities of the pelvis (B, 3, 64), metres per frame."""
        return (self.root[:, 1:] - self.root[:, :-1]).transpose(1, 2)

    @property
    def joints(self) -> torch.Tensor:
        """Joint positions (B, 65, 22, 3) in the view frame."""
        return self.positions + self.root[:, :, None]


def _way(start: Start, velocities: torch.Tensor) -> torch.Tensor:
    """Return the positions (B, 65, 3) of the pelvis."""
    steps = velocities.transpose(1, 2).cumsum(1)
    return start.root[:, None] + torch.cat([torch.zeros_like(steps[:, :1]), steps], dim=1)


def to_camera(points: torch.Tensor, camera: torch.Tensor) -> torch.Tensor:
    """Return points (B, ..., 3) of the view frame in camera coordinates (x right, y down, z forward)."""
    flat = points.flatten(1, -2)
    moved = flat @ camera[:, :, :3].transpose(1, 2) + camera[:, None, :, 3]
    return moved.view(points.shape)


def project(points: torch.Tensor, start: Start) -> torch.Tensor:
    """Return positions (B, ..., 2) in the picture of points (B, ..., 3).

    Positions are x and y in widths of the picture, from its upper left corner.
    """
    seen = to_camera(points, start.camera)
    ahead = seen[..., 2:].clamp(min=NEAREST)
    lens = start.lens.view(len(start), *(1 for _ in points.shape[1:-1]), 3)
    return lens[..., :1] * seen[..., :2] / ahead + lens[..., 1:]


def relative_depth(
    motions: Motions, start: Start, depth: torch.Tensor, size: tuple[int, int] = (36, 64)
) -> torch.Tensor:
    """Return the depth map around the pelvis, relative to its depth, in every EVERY-th frame (B, 9, *size), metres.

    depth: (B, 1, H, W) along the camera's axis. The crop is a spatial transformer (section 3.3.2): gradients reach the
    motion through the position of the crop and through the subtracted depth. Depths are clamped to 3 m around the body.
    """
    pelvis = motions.root[:, ::EVERY]
    place = project(pelvis, start)
    ahead = to_camera(pelvis, start.camera)[..., 2].clamp(min=NEAREST)
    half = REACH * start.lens[:, :1] / ahead  # in widths
    x, y = torch.meshgrid(
        torch.linspace(-1, 1, size[1], device=depth.device),
        torch.linspace(-ASPECT, ASPECT, size[0], device=depth.device),
        indexing="xy",
    )
    grid = place[:, :, None, None] + half[..., None, None, None] * torch.stack([x, y], -1)
    # grid_sample expects coordinates from -1 to 1 in each direction.
    grid = grid * constants.numbers((2.0, 2.0 / ASPECT), depth.device) - 1
    rows = grid.flatten(1, 2)
    found = functional.grid_sample(depth, rows, padding_mode="border", align_corners=False)
    return (found.view(len(start), -1, *size) - ahead[..., None, None]).clamp(-3, 3)
