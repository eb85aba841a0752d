"""One take in a scene: where it begins, its windows, its end on the floor."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import torch

from ....models.scene_gan import height_map
from ....models.scene_gan.networks import SceneGan
from ...body import human
from ...clock import Clock
from ...errors import SampError
from ...progress import Progress
from ...scene import geometry
from ...scene.navmesh.navmesh import NavMesh
from ..method import Draw
from ..scene_view import SceneView
from ..step import Step
from ..take import Take
from . import finishing, placing
from .frame import ViewFrame, rest_joints
from .ground import Ground
from .improvisation import Improvised, Improviser, frames_of
from .judging import Judge

HEIGHT_CELL, HEIGHT_REACH, HEIGHT_SAMPLES = 0.05, 8.0, 400_000
"""Of the height map around a start: metres, metres in each direction, samples of the surface."""
OFTEN = 3
"""Draws of a window on average from which on a take says so."""


class Maker:
    """Takes of one step in a scene."""

    def __init__(self, networks: SceneGan, scene: SceneView, mesh: NavMesh) -> None:
        self.networks, self.scene, self.mesh = networks, scene, mesh
        self.rest = rest_joints()
        self.ground = Ground(mesh, self._solid, -human.load().floor)
        self.judge = Judge(self.ground, tuple(scene.others))
        if scene.camera is None and networks.settings.view != "height":
            raise SampError("There is no picture for Improvise; add a camera that sees the room.")

    @property
    def _solid(self) -> np.ndarray:
        """All triangles (F, 3, 3), with an added ground where the scene has no floor."""
        return self.scene.geometry.triangles

    def take(self, step: Step, draw: Draw, clock: Clock, progress: Progress) -> Take:
        """Return the take of a draw. Raise SampError where it cannot begin or leaves the floor in every draw."""
        random = np.random.default_rng(draw.noise)
        settings = step.settings
        with clock.stage("start"):
            (root, rotations), frame = self._begin(draw.seed, random)
        frames = frames_of(float(settings.get("seconds") or 4.0))
        heights = self._heights if self.networks.settings.view == "height" else None
        improviser = Improviser(self.networks, frame, self.judge, self.rest, heights)
        with clock.stage("network"):
            made = improviser.improvise(
                root, rotations, frames, int(settings.get("draws") or 8), draw.noise,
                lambda share: progress("Improvising", share),
            )  # fmt: skip
        with clock.stage("finish"):
            motion = finishing.finish(made.root, made.rotations, self.ground)
        return Take(
            draw.seed, motion, method="scene_gan", seconds=dict(clock.seconds),
            camera=None if frame.view is None else frame.view.name, laid_ground=self.mesh.laid_ground,
            remarks=_remarks(made),
        )  # fmt: skip

    def _begin(self, seed: int, random: np.random.Generator) -> tuple[placing.Pose, ViewFrame]:
        """Return the pose in which a take begins and the frame of its view."""
        view, before = self.scene.camera, self.scene.after.get(seed)
        if before is not None:
            pose = placing.after(before)
            place, yaw = before.exit
            if view is not None:
                placing.require_in_view(view, place)
        else:
            if self.scene.start is None:
                place, yaw = placing.free_place(self.mesh, view, random, self.judge.meets)
            else:
                place, yaw = self.scene.start
                place = placing.on_floor(self.mesh, place)
                yaw = 0.0 if yaw is None else yaw
                if view is not None:
                    placing.require_in_view(view, place)
            pose = placing.standing(self.networks, self.ground, place, yaw, self.rest, random)
        if view is None:
            return pose, ViewFrame.beside(place, yaw + float(random.uniform(-np.pi, np.pi)))
        return pose, ViewFrame.of(view)

    @cached_property
    def _heights(self) -> tuple[torch.Tensor, torch.Tensor, float]:
        """Heights (1, 1, X, Z) of the highest surface under 1.8 m around the scene's middle, corner and cell."""
        floor = float(np.median(self.mesh.points[:, 1]))
        points, _ = geometry.sample_surface(self.scene.geometry.triangles, HEIGHT_SAMPLES, seed=0)
        middle = np.median(self.mesh.points, axis=0)[[0, 2]]
        corner, cells = middle - HEIGHT_REACH, int(2 * HEIGHT_REACH / HEIGHT_CELL)
        height = points[:, 1] - floor
        at = np.floor((points[:, [0, 2]] - corner) / HEIGHT_CELL).astype(int)
        fine = ((at >= 0) & (at < cells)).all(-1) & (height > -0.1) & (height < height_map.HIGHEST)
        grid = np.full((cells, cells), -1.0)
        np.maximum.at(grid, (at[fine, 0], at[fine, 1]), np.clip(height[fine], 0, None))
        tensor = lambda values: torch.as_tensor(values, dtype=torch.float32)
        return tensor(grid)[None, None], tensor(corner)[None], HEIGHT_CELL


def _remarks(made: Improvised) -> tuple[str, ...]:
    """Return how many windows were drawn, where that is more than usual."""
    if made.draws < OFTEN * made.windows:
        return ()
    return (f"{made.draws} draws were needed for {made.windows} windows to stay on free floor.",)
