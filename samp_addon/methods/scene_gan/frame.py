"""The view frame of the networks (models/scene_gan) for an artist's camera, and windows of motion in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch

from ....models.scene_gan import kinematics, scene_encoder
from ....models.scene_gan.projection import ASPECT, Motions
from ....models.scene_gan.start import Start
from ... import rotation, skeleton
from ...frames import yaw_direction, yawed_axes
from ...scene.camera_view import CameraView

BESIDE, EYE_LEVEL, FOCAL = 3.0, 1.6, 0.7
"""Of the assumed camera where there is none: metres from the start, metres over the floor, widths."""


@dataclass(frozen=True)
class ViewFrame:
    """eye: (3,) origin. yaw: of the Z axis, radians. camera: (3, 3) from the view frame to camera coordinates. lens:
    (3,) as of CameraView. view: the picture, or None."""

    eye: np.ndarray
    yaw: float
    camera: np.ndarray
    lens: np.ndarray
    view: CameraView | None = None

    @classmethod
    def of(cls, view: CameraView) -> ViewFrame:
        """Return the frame of a camera's view."""
        turn = view.extrinsics[:3, :3]
        return cls(view.eye, view.yaw, turn @ yawed_axes(view.yaw), view.lens, view)

    @classmethod
    def beside(cls, place: np.ndarray, yaw: float) -> ViewFrame:
        """Return the frame of an assumed camera that looks at a place on the floor (3,), level."""
        eye = place - BESIDE * yaw_direction(yaw) + [0.0, EYE_LEVEL, 0.0]
        return cls(eye, yaw, np.diag([-1.0, -1.0, 1.0]), np.array([FOCAL, 0.5, ASPECT / 2]))

    @property
    def axes(self) -> np.ndarray:
        """Matrix (3, 3) by which row vectors of the scene are multiplied."""
        return yawed_axes(self.yaw)

    def start(
        self, root: np.ndarray, rotations: np.ndarray, floor: float, rest: np.ndarray, count: int
    ) -> Start:
        """Return ``count`` equal starts that continue two frames of motion.

        root: (2, 3) of the pelvis; rotations: (2, 22, 4) local quaternions. floor: height under the second one. rest:
        (22, 3).
        """
        places = (root - self.eye) @ self.axes
        matrices = rotation.quaternion_to_matrix(rotations)
        matrices[:, 0] = self.axes.T @ matrices[:, 0]
        tensor = lambda values: torch.as_tensor(np.asarray(values), dtype=torch.float32)
        turned, bones = tensor(matrices), tensor(rest)
        joints = kinematics.joint_positions(turned, bones.expand(2, -1, -1))
        camera = tensor(np.concatenate([self.camera, np.zeros((3, 1))], axis=1))
        parts = (
            kinematics.six_numbers(turned)[1], tensor(places[1]), bones, joints[1] - joints[0],
            tensor(places[1] - places[0]), tensor(root[1, 1] - floor), camera, tensor(self.centred_lens(root[1])),
        )  # fmt: skip
        return Start(*(part.expand(count, *part.shape) for part in parts))

    def shift(self, place: np.ndarray) -> np.ndarray:
        """Return the whole pixels (2,), x and y, by which the picture is moved so that a place is in its middle."""
        if self.view is None:
            return np.zeros(2, int)
        at, _ = self.view.project(place)
        return np.round((np.array([0.5, ASPECT / 2]) - at) * self.view.depth.shape[1]).astype(int)

    def centred_lens(self, place: np.ndarray) -> np.ndarray:
        """Return the lens (3,) of the picture moved by `shift`."""
        if self.view is None:
            return self.lens
        return self.lens + np.array([0.0, *(self.shift(place) / self.view.depth.shape[1])])

    def picture(self, place: np.ndarray, kind: str) -> torch.Tensor:
        """Return the encoder's input (1, C, H, W) around a place, "colour" or "geometry"; black outside the picture."""
        shift = self.shift(place)
        if kind == "colour":
            return scene_encoder.normalised(torch.as_tensor(moved(self.view.colour, shift))[None])
        depth = torch.as_tensor(moved(self.view.depth, shift), dtype=torch.float32)[None]
        lens = torch.as_tensor(self.centred_lens(place), dtype=torch.float32)[None]
        return scene_encoder.geometry(depth, scene_encoder.normals_of(depth, lens))

    def to_scene(self, motions: Motions) -> tuple[np.ndarray, np.ndarray]:
        """Return windows in the scene: roots (B, 65, 3), local quaternions (B, 65, 22, 4)."""
        back = self.axes.T
        root = motions.root.double().numpy() @ back + self.eye
        matrices = kinematics.matrices(motions.six).double().numpy()
        matrices[:, :, 0] = self.axes @ matrices[:, :, 0]
        return root, rotation.matrix_to_quaternion(matrices)


def moved(values: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """Return a picture (H, W, ...) moved right and down by whole pixels (2,); 0 where nothing was."""
    height, width = values.shape[:2]
    rows, columns = np.arange(height) - shift[1], np.arange(width) - shift[0]
    out = values[np.clip(rows, 0, height - 1)][:, np.clip(columns, 0, width - 1)].copy()
    out[(rows < 0) | (rows >= height)] = 0
    out[:, (columns < 0) | (columns >= width)] = 0
    return out


def rest_joints() -> np.ndarray:
    """Return the rest joints (22, 3) of the default human."""
    return np.array(skeleton.default_rest_joints()[: skeleton.BODY_COUNT])
