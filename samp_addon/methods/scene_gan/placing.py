"""Where and how a take begins: where the character stands, or on free floor that the camera sees."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ....models.scene_gan import kinematics
from ....models.scene_gan.networks import SceneGan
from ... import rotation, skeleton
from ...errors import SampError
from ...motion import Motion
from ...scene.camera_view import CameraView
from ...scene.navmesh.navmesh import NavMesh
from .. import start_poses
from ..take import Take
from .ground import Ground

NEAREST, FARTHEST = 1.5, 7.0
"""Metres from the camera at which a character is placed."""
BODY = (0.3, 0.9, 1.5)
"""Heights over the floor that a camera has to see of a character; metres."""
MARGIN = 0.03  # widths of the picture
SEEN = 2  # of BODY
OPEN = 0.4  # metres of clearance that are wanted where a character is placed
BESIDE = 0.6  # metres from the navmesh up to which a start is moved onto it

Pose = tuple[np.ndarray, np.ndarray]
"""Two frames of motion: root (2, 3) and local quaternions (2, 22, 4)."""


def in_view(view: CameraView, places: np.ndarray) -> np.ndarray:
    """Return at which places on the floor (N, 3) a standing body is seen."""
    points = places[:, None] + np.array(BODY)[:, None] * np.array([0.0, 1.0, 0.0])
    return view.sees(points, MARGIN).sum(-1) >= SEEN


def seen_from(view: CameraView, pelvis: np.ndarray, floor: float) -> np.ndarray:
    """Return where bodies with pelvises (..., 3) over a floor are seen (...)."""
    places = pelvis * [1.0, 0.0, 1.0] + [0.0, floor, 0.0]
    return in_view(view, places.reshape(-1, 3)).reshape(places.shape[:-1])


def require_in_view(view: CameraView, place: np.ndarray) -> None:
    """Raise SampError where a character at a place on the floor (3,) is not in the picture."""
    if not in_view(view, place[None])[0]:
        raise SampError(
            f"The character is not in view of camera '{view.name}'; move one of them, or leave the start out to have "
            "the character placed."
        )


def free_place(
    mesh: NavMesh, view: CameraView | None, random: np.random.Generator,
    taken: Callable[[np.ndarray], np.ndarray] = lambda places: np.zeros(len(places), bool),
) -> tuple[np.ndarray, float]:  # fmt: skip
    """Return a random place on free floor in view, and a yaw. Raise SampError where there is none.

    taken: returns at which places (N, 3) another body is (N,).
    """
    numbers, points = mesh.walkable, mesh.points
    fine = ~mesh.ground.rough[numbers] & ~taken(points)
    if view is not None:
        away = np.linalg.norm(points - view.eye, axis=-1)
        fine &= (away > NEAREST) & (away < FARTHEST) & in_view(view, points)
        if not fine.any():
            raise SampError(
                f"Camera '{view.name}' sees no free floor between {NEAREST:g} and {FARTHEST:g} m; move or turn it."
            )
    chosen = np.flatnonzero(fine) if fine.any() else np.arange(len(points))
    clearance = mesh.ground.clearance[numbers[chosen]]
    chosen = chosen[clearance >= min(OPEN, np.quantile(clearance, 0.67))]
    return points[random.choice(chosen)], float(random.uniform(-np.pi, np.pi))


def on_floor(mesh: NavMesh, place: np.ndarray) -> np.ndarray:
    """Return the walkable place next to a start (3,). Raise SampError where it is inside something."""
    found = mesh.ground.points(np.array(mesh.nearest(place)))
    if np.linalg.norm((found - place)[[0, 2]]) > BESIDE:
        raise SampError("The character does not stand on free floor; move it beside the furniture.")
    return found


def standing(networks: SceneGan, ground: Ground, place: np.ndarray, yaw: float, rest: np.ndarray,
             random: np.random.Generator) -> Pose:  # fmt: skip
    """Return a captured standing pose at a place on the floor (3,), facing a yaw, twice."""
    poses = rotation.matrix_to_quaternion(kinematics.matrices(networks.standing).double().numpy())
    quats = random.choice(poses[start_poses.usable(poses)])
    quats[0] = rotation.multiply(rotation.about_y(yaw), quats[0])
    joints, _ = skeleton.forward_kinematics(np.zeros((1, 3)), quats[None], rest)
    # The lowest joint is as high over the floor as in the rest pose.
    height = ground.standing + float(rest[:, 1].min() - joints[0, :, 1].min())
    root = place + [0.0, height, 0.0]
    return np.stack([root, root]), np.stack([quats, quats])


def after(take: Take) -> Pose:
    """Return the last two frames of a take."""
    motion: Motion = take.motion.pose_slice(slice(-2, None)) if len(take.motion) > 1 else take.motion
    root, quats = motion.root[[0, -1]], motion.rotations[[0, -1], : skeleton.BODY_COUNT]
    return root, rotation.continuous(quats)
