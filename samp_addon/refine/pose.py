"""Differentiable joints and skin of a motion under smooth changes.

The changes are cubic B-splines in time: whatever the optimiser does, nothing pops. Only the body's 22 joints
change; hands and face follow wrist and head rigidly. Network frame, metres, radians.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np
import torch
from scipy.sparse import csr_array

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
    x, y, z = vectors.unbind(-1)
    xx, yy, zz = x * x, y * y, z * z
    angle = (xx + yy + zz + 1e-12).sqrt()
    a, b = torch.sin(angle) / angle, (1 - torch.cos(angle)) / angle.square()
    ax, ay, az, xy, yz, zx = a * x, a * y, a * z, b * x * y, b * y * z, b * z * x
    rows = [
        1 - b * (yy + zz), xy - az, zx + ay,
        xy + az, 1 - b * (zz + xx), yz - ax,
        zx - ay, yz + ax, 1 - b * (xx + yy),
    ]  # fmt: skip
    return _last(torch.stack(rows).unflatten(0, (3, 3)))


def _first(values: torch.Tensor) -> torch.Tensor:
    """Return matrices (..., 3, 3) as a view (3, 3, ...), in which they are multiplied several times as fast."""
    return values.movedim((-2, -1), (0, 1))


def _last(values: torch.Tensor) -> torch.Tensor:
    """Return matrices (3, 3, ...) as a view (..., 3, 3)."""
    return values.movedim((0, 1), (-2, -1))


def _times(a: torch.Tensor, b: torch.Tensor) -> torch.Tensor:
    """Return the products (3, ...) of matrices (3, 3, ...) and vectors (3, ...), or matrices (3, 3, ...)."""
    column = lambda k: a[:, k, None] if b.dim() == a.dim() else a[:, k]
    return column(0) * b[0] + column(1) * b[1] + column(2) * b[2]


class Pose:
    """The joints of a motion as a function of changes to it."""

    def __init__(self, motion: Motion, body: Human) -> None:
        self.body, self.motion = body, motion
        rotations = complete(motion.rotations)
        local = rotation.quaternion_to_matrix(rotations)
        placed, turned = skeleton.forward_kinematics(motion.root, rotations, body.joints)
        turned = rotation.quaternion_to_matrix(turned)
        anchor = _anchors()
        # Hands and face are kept in the frame of the wrist or head that carries them.
        held = turned[:, anchor].swapaxes(-1, -2)
        away = (held @ (placed - placed[:, anchor])[..., None])[..., 0]
        tensor = lambda a: torch.tensor(np.ascontiguousarray(a), dtype=torch.float32)
        self._anchor = torch.as_tensor(anchor)
        # By coordinate, see _first.
        self._local = tensor(np.moveaxis(local[:, :_BODY], (-2, -1), (0, 1)))
        self._local_turns = tensor(np.moveaxis(held @ turned, (-2, -1), (0, 1)))
        self._local_places = tensor(np.moveaxis(away, -1, 0))
        self._root = tensor(motion.root.T)
        levels = _levels()
        self._order = torch.as_tensor(np.argsort([j for level in levels for j in level]))
        self._levels = [
            _below(above, joints, tensor(body.joints.T)) for above, joints in itertools.pairwise(levels)
        ]

    def locally(self, turn: torch.Tensor) -> torch.Tensor:
        """Return the local rotation matrices (T, 22, 3, 3). turn: (T, 22, 3) rotation vectors, applied after each
        joint's own rotation."""
        return _last(_times(self._local, _first(rotation_matrices(turn))))

    def joints(self, shift: torch.Tensor, local: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return positions (T, 22, 3) and global rotation matrices (T, 22, 3, 3) of the body's joints.

        shift: (T, 3) of the root, metres. local: see `locally`.
        """
        local = _first(local)
        turned, placed = [local[..., :1]], [(self._root + shift.T)[..., None]]
        for joints, rows, bones in self._levels:
            above, at = turned[-1].index_select(-1, rows), placed[-1].index_select(-1, rows)
            turned.append(_times(above, local.index_select(-1, joints)))
            placed.append(at + _times(above, bones))
        placed, turned = (torch.cat(parts, -1).index_select(-1, self._order) for parts in (placed, turned))
        return placed.movedim(0, -1), _last(turned)

    def transforms(self, placed: torch.Tensor, turned: torch.Tensor, frames: torch.Tensor) -> torch.Tensor:
        """Return the transforms (3, 4, N, 55) from the frames of all joints to the world, in some frames (N,)."""
        carried = lambda values: values.index_select(-2, frames).index_select(-1, self._anchor)
        held = carried(_first(turned))
        away = _times(held, self._local_places.index_select(-2, frames))
        matrices = _times(held, self._local_turns.index_select(-2, frames))
        return torch.cat([matrices, (carried(placed.movedim(-1, 0)) + away)[:, None]], 1)


def changed(motion: Motion, shift: np.ndarray, turn: np.ndarray) -> Motion:
    """Return the motion with its root shifted by (T, 3) and its body joints turned by rotation vectors (T, 22, 3)."""
    rotations = motion.rotations.copy()
    rotations[:, :_BODY] = rotation.multiply(rotations[:, :_BODY], rotation.from_axis_angle(turn))
    return replace(motion, root=motion.root + shift, rotations=rotations)


@dataclass(frozen=True)
class Along:
    """How far points of the skin have moved along fixed directions since they were looked at, linear in the pose.

    matrix: (N, 12 * R * 55) of N points and directions. base: (3, 4, R, 55) transforms of the joints at that time.
    start: (N,) metres along the directions of the points at that time.
    """

    matrix: csr_array
    base: torch.Tensor
    start: np.ndarray

    def at(self, transforms: torch.Tensor) -> torch.Tensor:
        """Return the metres (N,) for other transforms (3, 4, R, 55)."""
        return _Product.apply((transforms - self.base).flatten(), self.matrix)


class _Product(torch.autograd.Function):
    """The product of a sparse matrix and a vector. SciPy's takes a tenth of the time of gathering and summing."""

    @staticmethod
    def forward(
        ctx: torch.autograd.function.FunctionCtx, values: torch.Tensor, matrix: csr_array
    ) -> torch.Tensor:
        ctx.matrix = matrix
        return torch.from_numpy(matrix @ values.detach().numpy())

    @staticmethod
    def backward(
        ctx: torch.autograd.function.FunctionCtx, gradient: torch.Tensor
    ) -> tuple[torch.Tensor, None]:
        return torch.from_numpy(ctx.matrix.T @ gradient.numpy()), None


class Skin:
    """Linear blend skinning of some vertices, each moved by four joints."""

    def __init__(self, body: Human, vertices: np.ndarray) -> None:
        """vertices: (V,) indices into the body's vertices."""
        self.body, self.carriers, weights = body, body.weight_joints[vertices], body.weights[vertices]
        about = body.vertices[vertices][:, None] - body.joints[self.carriers]
        points = np.concatenate([about, np.ones((*about.shape[:2], 1))], -1) * weights[..., None]
        self.points = points.astype(np.float32)  # (V, 4, 4), weighted

    def along(self, motion: Motion, rows: np.ndarray, vertices: np.ndarray, directions: np.ndarray) -> Along:
        """Return how far vertices (N,) in the frames (N,) of a motion move along directions (N, 3) from where they are.

        vertices: indices into those of this skin.
        """
        size, joints = len(motion) * len(skeleton.JOINTS), len(skeleton.JOINTS)
        data = self.points[vertices][:, :, None] * directions.astype(np.float32)[:, None, :, None]
        first = rows[:, None] * joints + self.carriers[vertices]
        columns = (first[..., None] + np.arange(12) * size).astype(np.int32)
        each = np.arange(len(rows) + 1, dtype=np.int32) * (4 * 12)
        matrix = csr_array((data.ravel(), columns.ravel(), each), (len(rows), 12 * size))
        matrix.eliminate_zeros()  # most vertices are moved by fewer joints
        rotations = complete(motion.rotations)
        placed, turned = skeleton.forward_kinematics(motion.root, rotations, self.body.joints)
        base = np.concatenate([rotation.quaternion_to_matrix(turned), placed[..., None]], -1)
        base = np.ascontiguousarray(np.moveaxis(base, (-2, -1), (0, 1)))
        return Along(matrix, torch.tensor(base, dtype=torch.float32), matrix @ base.ravel())


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


def _below(
    above: list[int], joints: list[int], rest: torch.Tensor
) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Return the joints (N,) of a level, the places (N,) of their parents in the level above, and the bones (3, 1, N)
    between them, metres. rest: (3, 55) of the rest pose."""
    parents = [int(skeleton.PARENTS[j]) for j in joints]
    bones = (rest[:, joints] - rest[:, parents])[:, None]
    return torch.tensor(joints), torch.tensor([above.index(p) for p in parents]), bones
