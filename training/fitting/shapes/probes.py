"""Probe points on and inside the default human's skin, for fitting: a few hundred instead of 12,000."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ....samp_addon import skeleton
from ....samp_addon.body import human
from ....samp_addon.motion import Motion
from ....samp_addon.scene.distance.solids import BoxedTriangles, solid_cells

PITCH = 0.03
DENSE = 0.016
INSIDE = 0.012  # depth (m) under the skin from which a point counts as inside
_SEAT = ("pelvis", "left_hip", "right_hip", "spine1")
_BACK = ("pelvis", "spine1", "spine2", "spine3", "left_collar", "right_collar", "neck")
_SHANKS = ("left_knee", "right_knee", "left_ankle", "right_ankle", "left_foot", "right_foot")
_ARMS = ("shoulder", "elbow", "wrist")


@dataclass(frozen=True, eq=False)
class Probes:
    """Indices of probe points.

    skin: (N,) indices of the collision vertices. seat, back, shanks, left_arm, right_arm: rows of ``skin`` under pelvis
    and thighs, on the rear of the trunk, from the knee down, and of the arms. inside: a body whose vertices are points
    inside the skin; depth: (M,) metres from these to the skin in the rest pose.
    """

    skin: np.ndarray
    seat: np.ndarray
    back: np.ndarray
    upper_back: np.ndarray
    shanks: np.ndarray
    left_arm: np.ndarray
    right_arm: np.ndarray
    inside: human.Human
    depth: np.ndarray


@functools.cache
def load() -> Probes:
    """Return the probes of the default human."""
    body = human.load()
    owner = np.take_along_axis(body.weight_joints, body.weights.argmax(1)[:, None], 1)[:, 0]
    names = np.array(skeleton.JOINTS)[owner]
    normals = _normals(body)
    skin, joint, facing = body.collision, names[body.collision], normals[body.collision]
    rows = lambda some, more=True: np.flatnonzero(np.isin(joint, some) & more)
    fingers = [j for j in skeleton.JOINTS if j[-1].isdigit() and "spine" not in j]
    arms = {
        side: rows([f"{side}_{name}" for name in _ARMS] + [j for j in fingers if j.startswith(side)])
        for side in ("left", "right")
    }
    seat = rows(_SEAT, (facing[:, 2] < 0.35))
    back = rows(_BACK, facing[:, 2] < -0.25)
    upper = rows(("spine1", "spine2", "spine3"), facing[:, 2] < -0.5)
    inside, depth = _inside(body)
    return Probes(skin, seat, back, upper, rows(_SHANKS), arms["left"], arms["right"], inside, depth)


def _normals(body: human.Human) -> np.ndarray:
    """Return the unit normals (V, 3) of the rest pose."""
    faces = body.faces[:, :3]
    a, b, c = (body.vertices[faces[:, k]] for k in range(3))
    normals = np.zeros_like(body.vertices)
    for k in range(3):
        np.add.at(normals, faces[:, k], np.cross(b - a, c - a))
    return normals / np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)


def _inside(body: human.Human) -> tuple[human.Human, np.ndarray]:
    """Return the body with interior points as its vertices, skinned like the nearest skin, and their depths (M,)."""
    quads = body.faces
    triangles = np.concatenate([body.vertices[quads[:, :3]], body.vertices[quads[:, [0, 2, 3]]]])
    low = triangles.min((0, 1)) - 2 * PITCH
    shape = np.ceil((triangles.max((0, 1)) + 2 * PITCH - low) / PITCH).astype(int)
    solid = solid_cells(BoxedTriangles.of(triangles), low, shape, [0] * 6, PITCH)
    points = low + (np.argwhere(solid) + 0.5) * PITCH
    depth, near = cKDTree(body.vertices).query(points)
    some = depth > INSIDE
    points, near, depth = points[some], near[some], depth[some]
    made = replace(
        body,
        vertices=points,
        weight_joints=body.weight_joints[near],
        weights=body.weights[near],
        shapes={},
        collision=np.arange(len(points)),
    )
    return made, depth


def skinned(root: np.ndarray, rotations: np.ndarray, rows: np.ndarray | None = None) -> np.ndarray:
    """Return collision vertices (T, N, 3) of poses, metres; rows: of Probes.skin, or None for all."""
    probes, body = load(), human.load()
    chosen = probes.skin if rows is None else probes.skin[rows]
    return human.skin(body, Motion(root, rotations), chosen).astype(np.float64)


@functools.cache
def _dense() -> np.ndarray:
    """Return the indices of one skin vertex in each cell of 1.6 cm of the rest pose."""
    cells = np.floor(human.load().vertices / DENSE).astype(int)
    return np.sort(np.unique(cells, axis=0, return_index=True)[1])


def dense(root: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    """Return skin vertices (T, D, 3) of poses, metres, denser than the collision vertices."""
    return human.skin(human.load(), Motion(root, rotations), _dense()).astype(np.float64)


def interior(root: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    """Return points (T, M, 3) inside the body of poses, metres."""
    inside = load().inside
    return human.skin(inside, Motion(root, rotations), inside.collision).astype(np.float64)


@functools.cache
def owners() -> np.ndarray:
    """Return the names (N,) of the joints with the largest weight at the collision vertices."""
    body = human.load()
    return _owner(body)[load().skin]


@functools.cache
def inner_owners() -> np.ndarray:
    """Return the names (M,) of the joints with the largest weight at the interior points."""
    return _owner(load().inside)


def _owner(body: human.Human) -> np.ndarray:
    owner = np.take_along_axis(body.weight_joints, body.weights.argmax(1)[:, None], 1)[:, 0]
    return np.array(skeleton.JOINTS)[owner]


@functools.cache
def named(*joints: str) -> np.ndarray:
    """Return the rows of Probes.skin whose largest weight is of one of these joints."""
    return np.flatnonzero(np.isin(owners(), joints))


@functools.cache
def hand(side: str) -> np.ndarray:
    """Return the rows of Probes.skin of one forearm, hand and fingers."""
    arm = load().left_arm if side == "left" else load().right_arm
    return arm[~np.isin(owners()[arm], (f"{side}_shoulder",))]
