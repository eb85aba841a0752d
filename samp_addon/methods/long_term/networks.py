"""The trained networks, from bodies in the scene to bodies in the scene. Torch is imported at import."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch

from ....models import weights
from ....models.long_term import gait, layout, sub_goal_net
from ....models.long_term.guided_net import LATENT
from ....models.long_term.guided_pose import SIX, GuidedPose, PoseEnds
from ....models.long_term.guided_route import FPS, GuidedRoute, RouteEnds
from ....models.long_term.pose_prior import PosePrior
from ... import rotation
from ...body import hand_poses
from ...errors import SampError
from ...motion import Motion
from ...torch_threads import single_thread
from ...vocabulary import SEATED
from . import resting
from .figure import Figure, as_motion
from .installed import WEIGHTS

FRAMES = (14, 90)
"""Fewest and most frames of a window; longer ones were not trained."""


@dataclass(frozen=True)
class Wanted:
    """Where a body is asked for: what it does there, place (3,) of the pelvis, facing in radians, level of the floor,
    shape, and the gait (2,): zeros for a body that stays, else cosine and sine of its phase."""

    action: str
    place: np.ndarray
    yaw: float
    level: float
    betas: np.ndarray
    gait: np.ndarray


@dataclass(frozen=True)
class Crossing:
    """A window to be filled. path: (16, 3) on the floor from start to end. moving: whether start and end are walked
    through. speed: factor on the usual pace. z: noise (8,) of route and of pose. sits: whether the body sits at start
    and end."""

    start: Figure
    end: Figure
    path: np.ndarray
    moving: tuple[bool, bool]
    speed: float
    z: tuple[np.ndarray, np.ndarray]
    sits: tuple[bool, bool] = (False, False)


class Networks:
    """Pose prior, sub-goal bodies, routes and poses."""

    def __init__(
        self, prior: PosePrior, bodies: sub_goal_net.SubGoalNet, route: GuidedRoute, pose: GuidedPose
    ) -> None:
        self.prior, self.bodies, self.route, self.pose = prior, bodies, route, pose

    @torch.no_grad()
    def sample_bodies(
        self, wanted: Wanted, cloud: np.ndarray, noise: np.ndarray, turns: np.ndarray
    ) -> list[Figure]:
        """Return a body for each row of noise (K, 32), section 3.2.

        cloud: (N, 3) around the place, world. turns: (K,) rows of the table of captured orientations.
        """
        with single_thread():
            origin = np.array([wanted.place[0], wanted.level, wanted.place[2]])
            count = len(noise)
            action = wanted.action if wanted.action in SEATED else "idle"
            heights = torch.full((count,), float(wanted.place[1] - wanted.level))
            given = self.bodies.given(action, heights, torch.as_tensor(turns))
            kind = np.array([float(action == name) for name in sub_goal_net.ACTIONS])
            shape, phase, kind = (_tensor(v).expand(count, -1) for v in (wanted.betas, wanted.gait, kind))
            points = _tensor(_seen(cloud, origin, wanted.yaw))[None]
            condition = self.bodies.condition(points.expand(count, -1, -1), shape, given, phase, kind)
            made = self.bodies.decode(condition, given, _tensor(noise))
            t, r, p, h = layout.split_body(made)
            pelvis = layout.about_y(torch.tensor(wanted.yaw)) @ layout.matrix_from_six(r)
            turns = torch.cat([pelvis[:, None], self.prior.decode(p)], 1)
        places = _world(t.double().numpy(), origin, wanted.yaw)
        quats = rotation.matrix_to_quaternion(turns.double().numpy())
        return [
            Figure(place, q, hand, wanted.betas, wanted.level)
            for place, q, hand in zip(places, quats, h.double().numpy(), strict=True)
        ]

    @torch.no_grad()
    def cross(self, crossing: Crossing, cloud: np.ndarray, frames: int = 0) -> Motion:
        """Return the motion of a window, both ends included (section 3.3).

        cloud: (N, 3) around both ends, world. frames: of the window; 0 for as many as it usually takes.
        """
        start, end = crossing.start, crossing.end
        origin, yaw = np.array([start.root[0], start.level, start.root[2]]), start.yaw
        with single_thread():
            ends = self._ends(crossing, origin, yaw)
            if not frames:
                seconds = float(self.route.seconds(ends)[0]) / crossing.speed
                frames = int(np.clip(round(seconds * FPS) + 1, *FRAMES))
            points = _tensor(_seen(cloud, origin, yaw))[None]
            route = self.route(ends, frames, points, _tensor(crossing.z[0])[None])
            heights = resting.raised(route[0, :, :3].double().numpy(), crossing.sits)
            route[0, :, 1] = _tensor(heights)
            total = gait.advance(ends.start_gait, ends.end_gait, ends.length)
            planned = gait.planned(_phases([start])[0], total, route)
            poses = self.pose(_pose_ends(start, end), route, planned, points, _tensor(crossing.z[1])[None])
            turns = layout.matrix_from_six(poses[0, :, :SIX].unflatten(-1, (layout.JOINTS, 6)))
            pelvis = layout.about_y(torch.tensor(yaw)) @ layout.matrix_from_six(route[0, :, 3:])
            matrices = torch.cat([pelvis[:, None], turns], 1).double().numpy()
        hands = poses[0, :, SIX:].double().numpy()
        quats = hand_poses.with_hands(rotation.matrix_to_quaternion(matrices), hands)
        root = _world(route[0, :, :3].double().numpy(), origin, yaw)
        return Motion(root, rotation.continuous(quats), fps=FPS, rest_joints=as_motion([start]).rest_joints)

    def _ends(self, crossing: Crossing, origin: np.ndarray, yaw: float) -> RouteEnds:
        """Return what RouteNet is given, in the frame of the start."""
        both = []
        for figure in (crossing.start, crossing.end):
            matrix = rotation.quaternion_to_matrix(
                rotation.multiply(rotation.about_y(-yaw), figure.rotations[0])
            )
            place = _seen(figure.root[None], origin, yaw)[0]
            both.append(torch.cat([_tensor(place), layout.six_from_matrix(_tensor(matrix))])[None])
        path = _tensor(_seen(crossing.path, origin, yaw)[:, [0, 2]])[None]
        gaits = [
            _phases([figure])[0] * float(moving)
            for figure, moving in zip((crossing.start, crossing.end), crossing.moving, strict=True)
        ]
        return RouteEnds(*both, path, _tensor(crossing.start.betas)[None], *gaits)


def phase(figure: Figure) -> np.ndarray:
    """Return cosine and sine (2,) of the phase of a figure in its stride."""
    return _phases([figure])[0][0].double().numpy()


def _phases(figures: list[Figure]) -> torch.Tensor:
    """Return cosine and sine (K, 1, 2) of the phases of figures."""
    joints = _tensor(np.array([figure.joints for figure in figures]))
    read = gait.phase_of(joints, _tensor(np.array([figure.yaw for figure in figures])))
    return torch.nn.functional.normalize(read, dim=-1)[:, None]


def _pose_ends(start: Figure, end: Figure) -> PoseEnds:
    poses = []
    for figure in (start, end):
        turns = _tensor(rotation.quaternion_to_matrix(figure.rotations[1:]))
        poses.append(torch.cat([layout.six_from_matrix(turns).flatten(), _tensor(figure.hands)])[None])
    return PoseEnds(*poses, _tensor(start.betas)[None])


def noises(rng: np.random.Generator, scale: float) -> tuple[np.ndarray, np.ndarray]:
    """Return noise (8,) for a route and for its poses."""
    return tuple(scale * rng.standard_normal(LATENT) for _ in range(2))


def body_noise(rng: np.random.Generator, count: int, scale: float) -> np.ndarray:
    """Return noise (count, 32) for bodies."""
    return scale * rng.standard_normal((count, sub_goal_net.LATENT))


def body_turns(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return rows (count,) of the table of captured orientations."""
    return rng.integers(sub_goal_net.TURNS, size=count)


def _tensor(values: np.ndarray) -> torch.Tensor:
    return torch.as_tensor(np.asarray(values), dtype=torch.float32)


def _seen(points: np.ndarray, origin: np.ndarray, yaw: float) -> np.ndarray:
    """Return world points (..., 3) in the frame of a place."""
    return rotation.rotate(np.broadcast_to(rotation.about_y(-yaw), (*points.shape[:-1], 4)), points - origin)


def _world(points: np.ndarray, origin: np.ndarray, yaw: float) -> np.ndarray:
    """Return points (..., 3) in the frame of a place as world points."""
    return rotation.rotate(np.broadcast_to(rotation.about_y(yaw), (*points.shape[:-1], 4)), points) + origin


@functools.cache
def _load(folder: Path | None, versions: tuple) -> Networks:
    nets = []
    for name, net in zip(
        WEIGHTS, (PosePrior(), sub_goal_net.SubGoalNet(), GuidedRoute(), GuidedPose()), strict=True
    ):
        weights.fill(net, weights.load_weights(name, folder), weights.weights_path(name, folder))
        nets.append(net.eval().requires_grad_(False))
    return Networks(*nets)


def load(folder: Path | None = None) -> Networks:
    """Return the trained networks, cached. folder: of other weights than the shipped ones. Raises SampError."""
    try:
        return _load(folder, tuple(weights.file_version(name, folder) for name in WEIGHTS))
    except weights.WeightsError as error:
        raise SampError(str(error)) from error
