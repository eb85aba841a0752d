"""Encoder and generators of Scene GAN with their settings, saved and loaded together."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

import torch
from torch import nn

from .. import weights
from .generators import JointGenerator, PoseGenerator, Sizes, TrajectoryGenerator
from .height_map import HeightMapEncoder
from .kinematics import JOINTS
from .projection import Motions
from .scene_encoder import SceneEncoder
from .start import Start

NAME, HEIGHT_NAME = "scene_gan", "scene_gan_height"
"""Names of the weights of networks for pictures, and of those for height maps."""
VIEWS = ("colour", "geometry", "height")
STANDING = 16
"""Number of standing poses stored with the networks; takes start in one of them."""


@dataclass(frozen=True)
class Settings:
    """Settings of the networks.

    view: of the scene: the picture's colours, its depth and normals, or the height map. separate: a trajectory
    generator and a pose generator (M of table 1), or CSGN. encoder_width: of the encoder's first stage.
    """

    view: str = "colour"
    separate: bool = True
    scene: int = 256
    width: int = 512
    noise: int = 256
    pose_noise: int = 1024
    encoder_width: int = 64

    def __post_init__(self) -> None:
        if self.view not in VIEWS:
            raise ValueError(f"view is '{self.view}'; choose one of {', '.join(VIEWS)}")

    @property
    def sizes(self) -> Sizes:
        """The widths of generators and critics."""
        return Sizes(self.scene, self.width, self.noise, self.pose_noise)


def encoder(settings: Settings) -> SceneEncoder | HeightMapEncoder:
    """Return an untrained encoder."""
    if settings.view == "height":
        return HeightMapEncoder(settings.scene, settings.encoder_width)
    return SceneEncoder(settings.scene, 3 if settings.view == "colour" else 4, settings.encoder_width)


class SceneGan(nn.Module):
    """Encoder and generators.

    standing: (STANDING, 22, 6) captured rotations of standing bodies that face +Z.
    """

    standing: torch.Tensor

    def __init__(self, settings: Settings) -> None:
        super().__init__()
        self.settings = settings
        upright = torch.tensor([1.0, 0, 0, 0, 1, 0]).expand(STANDING, JOINTS, 6)
        self.register_buffer("standing", upright.clone())
        self.encoder = encoder(settings)
        if settings.separate:
            self.trajectory = TrajectoryGenerator(settings.sizes)
            self.pose = PoseGenerator(settings.sizes)
        else:
            self.joint = JointGenerator(settings.sizes)

    def draw(
        self, scene: torch.Tensor, start: Start, generator: torch.Generator | None = None,
        velocities: torch.Tensor | None = None,
    ) -> Motions:  # fmt: skip
        """Return a window for each scene feature (B, scene) and start (equation 2).

        velocities: (B, 3, 64) metres per frame, in place of generated ones, for poses on given trajectories.
        """
        count = len(start)
        if not self.settings.separate:
            made, six = self.joint(self.joint.latent.draw(count, generator), scene, start)
            return Motions.of(start, made, six)
        if velocities is None:
            velocities = self.trajectory(self.trajectory.latent.draw(count, generator), scene, start)
        six = self.pose(self.pose.latent.draw(count, generator), scene, start, velocities)
        return Motions.of(start, velocities, six)


def save(networks: SceneGan, folder: Path | None = None) -> Path:
    """Write the weights and, next to them, the settings; return the weights' path."""
    name = HEIGHT_NAME if networks.settings.view == "height" else NAME
    path = weights.save_weights(name, networks.state_dict(), folder)
    path.with_suffix(".json").write_text(json.dumps(asdict(networks.settings), indent=1) + "\n")
    return path


def load(folder: Path | None = None, name: str = "") -> SceneGan:
    """Return trained networks in evaluation mode.

    name: of the weights; by default those for pictures, or those for height maps if there are no others. Raise
    WeightsError for missing or damaged files.
    """
    if not name:
        there = [known for known in (NAME, HEIGHT_NAME) if weights.weights_path(known, folder).exists()]
        name = there[0] if there else NAME
    tensors = weights.load_weights(name, folder)
    path = weights.weights_path(name, folder)
    try:
        settings = Settings(**json.loads(path.with_suffix(".json").read_text()))
    except (OSError, ValueError, TypeError) as error:
        raise weights.WeightsError(f"The settings of '{path.name}' are missing or damaged.") from error
    made = SceneGan(settings)
    full = {key: value.float() if value.is_floating_point() else value for key, value in tensors.items()}
    weights.fill(made, full, path)
    return made.eval()
