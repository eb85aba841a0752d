"""Differentiable joints and skin of a motion under smooth changes.

The changes are cubic B-splines in time: whatever the optimiser does, nothing pops. Only the body's 22 joints
change; hands and face follow wrist and head rigidly. Network frame, metres, radians.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch

from .. import rotation, skeleton
from ..body.hands import complete
from ..body.human import Human
from ..motion import Motion

KNOT_SECONDS = 0.16
_BODY = skeleton.BODY_COUNT


def spline_basis(frames: int, fps: float, spacing: float = KNOT_SECONDS) -> np.ndarray:
    """Return the weights (T, K) of the knots in each frame: uniform cubic B-splines, whose rows add up to 1."""
    at = np.arange(frames) / fps / spacing
    first = np.minimum(at.astype(int), max(int(np.ceil(at[-1])) - 1, 0))
    u = at - first
    share = np.stack(
        [(1 - u) ** 3, 3 * u**3 - 6 * u**2 + 4, -3 * u**3 + 3 * u**2 + 3 * u + 1, u**3], -1
    ) / 6  # fmt: skip
    basis = np.zeros((frames, int(first[-1]) + 4))
    for k in range(4):
        basis[np.arange(frames), first + k] = share[:, k]
    return basis


def rotation_matrices(vectors: torch.Tensor) -> torch.Tensor:
    """Return the matrices (..., 3, 3) of rotation vectors (..., 3), by Rodrigues' formula."""
    square = vectors.square().sum(-1, keepdim=True)[..., None]
    angle = (square + 1e-12).sqrt()
    x, y, z = vectors.unbind(-1)
    zero = torch.zeros_like(x)
    cross = torch.stack([zero, -z, y, z, zero, -x, -y, x, zero], -1).unflatten(-1, (3, 3))
    eye = torch.eye(3, dtype=vectors.dtype)
    return eye + torch.sin(angle) / angle * cross + (1 - torch.cos(angle)) / angle.square() * (cross @ cross)


class Pose:
    """The joints of a motion as a function of changes to it."""

    def __init__(self, motion: Motion, body: Human) -> None:
        self.body, self.motion = body, motion
        rotations = complete(motion.rotations)
        local = rotation.quaternion_to_matrix(rotations)
        _, turned = skeleton.forward_kinematics(motion.root, rotations, body.joints)
        turned = rotation.quaternion_to_matrix(turned)
        self.anchor = _anchors()
        rest = body.joints
        # Hands and face are kept in the frame of the wrist or head that carries them.
        placed, _ = skeleton.forward_kinematics(motion.root, rotations, rest)
        held = turned[:, self.anchor].swapaxes(-1, -2)
        tensor = lambda a: torch.tensor(np.asarray(a), dtype=torch.float32)
        self.local, self.root = tensor(local[:, :_BODY]), tensor(motion.root)
        self.rest = tensor(rest)
        self.local_turns = tensor(held @ turned)
        away = placed - placed[:, self.anchor]
        self.local_places = tensor((held @ away[..., None])[..., 0])
        self.levels = _levels()

    def joints(self, shift: torch.Tensor, turn: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return positions (T, 22, 3) and global rotation matrices (T, 22, 3, 3) of the body's joints.

        shift: (T, 3) of the root, metres. turn: (T, 22, 3) rotation vectors, applied after each joint's own rotation.
        """
        local = self.local @ rotation_matrices(turn)
        where = {0: (0, 0)}
        turned, placed = [local[:, :1]], [(self.root + shift)[:, None]]
        for level, joints in enumerate(self.levels[1:], start=1):
            parents = [int(skeleton.PARENTS[j]) for j in joints]
            rows = torch.tensor([where[p][1] for p in parents])
            above, at = turned[level - 1].index_select(1, rows), placed[level - 1].index_select(1, rows)
            bones = self.rest[joints] - self.rest[parents]
            turned.append(above @ local[:, joints])
            placed.append(at + (above @ bones[..., None])[..., 0])
            where |= {j: (level, row) for row, j in enumerate(joints)}
        order = [j for level in self.levels for j in level]
        back = torch.as_tensor(np.argsort(order))
        return torch.cat(placed, 1)[:, back], torch.cat(turned, 1)[:, back]

    def transforms(self, placed: torch.Tensor, turned: torch.Tensor, frames: torch.Tensor) -> torch.Tensor:
        """Return the transforms (N, 55, 3, 4) from the frames of all joints to the world, in some frames (N,)."""
        anchor = torch.as_tensor(self.anchor)
        held = turned.index_select(0, frames).index_select(1, anchor)
        matrices = held @ self.local_turns[frames]
        places = (
            placed.index_select(0, frames).index_select(1, anchor)
            + (held @ self.local_places[frames][..., None])[..., 0]
        )
        return torch.cat([matrices, places[..., None]], -1)


def changed(motion: Motion, shift: np.ndarray, turn: np.ndarray) -> Motion:
    """Return the motion with its root shifted by (T, 3) and its body joints turned by rotation vectors (T, 22, 3)."""
    rotations = motion.rotations.copy()
    rotations[:, :_BODY] = rotation.multiply(rotations[:, :_BODY], rotation.from_axis_angle(turn))
    return replace(motion, root=motion.root + shift, rotations=rotations)


class Skin:
    """Linear blend skinning of some vertices, each moved by four joints."""

    def __init__(self, body: Human, vertices: np.ndarray) -> None:
        """vertices: (V,) indices into the body's vertices."""
        carriers, weights = body.weight_joints[vertices], body.weights[vertices]
        about = body.vertices[vertices][:, None] - body.joints[carriers]
        self.carriers = torch.as_tensor(carriers)
        points = np.concatenate([about, np.ones((*about.shape[:2], 1))], -1) * weights[..., None]
        self.points = torch.as_tensor(points, dtype=torch.float32)  # (V, 4, 4), weighted

    def at(self, transforms: torch.Tensor, rows: torch.Tensor, vertices: torch.Tensor) -> torch.Tensor:
        """Return the positions (N, 3) of vertices (N,) under the transforms (T, 55, 3, 4), in rows (N,)."""
        flat = transforms.flatten(0, 1).flatten(1)
        index = rows[:, None] * transforms.shape[1] + self.carriers[vertices]
        # Gradients of plain indexing are summed by threads in no fixed order, and takes would not repeat.
        carried = flat.index_select(0, index.flatten()).unflatten(0, index.shape).unflatten(-1, (3, 4))
        return (carried * self.points[vertices][:, :, None]).sum((1, 3))


def _anchors() -> np.ndarray:
    """Return for each of the 55 joints the body joint (55,) that carries it; body joints carry themselves."""
    anchor = np.arange(len(skeleton.JOINTS))
    for j in range(_BODY, len(anchor)):
        anchor[j] = anchor[skeleton.PARENTS[j]]
    return anchor


def _levels() -> list[list[int]]:
    """Return the body's joints by their depth below the pelvis."""
    depth = np.zeros(_BODY, int)
    for j in range(1, _BODY):
        depth[j] = depth[skeleton.PARENTS[j]] + 1
    return [[int(j) for j in np.flatnonzero(depth == d)] for d in range(depth.max() + 1)]
