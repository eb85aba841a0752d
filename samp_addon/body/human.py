"""The default human: mesh, joints, skin weights and shapes, and linear blend skinning.

Written by training/build_body.py into human.npz. Network frame, metres, the pelvis joint at the origin in the
rest pose, which is SMPL-X's T-pose.
"""

from __future__ import annotations

import functools
import zipfile
import zlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from .. import rotation, skeleton
from ..errors import SampError
from ..motion import Motion
from . import brows
from .hands import complete

ASSET = Path(__file__).parent / "human.npz"
SIZE = "size"
"""Name of what is no shape but the size of the whole body."""
SPINE = ("spine1", "spine2", "spine3")
MATERIALS = ("skin", "clothes", "trousers", "shoes", "hair", "eyes", "pupils")


@dataclass(frozen=True, eq=False)
class Human:
    """A body in the rest pose. Arrays are read-only; network frame, metres, pelvis joint at the origin.

    vertices: (V, 3). faces: (F, 4) vertex indices; a triangle repeats its last one. joints: (55, 3).
    weight_joints: (V, 4) joint indices. weights: (V, 4) their skin weights, which sum to 1.
    shapes: name -> (vertex offsets (V, 3), joint offsets (55, 3)) at value 1.
    collision: (2048,) vertex indices, evenly distributed over the skin. materials: (F,) indices into MATERIALS.
    """

    vertices: np.ndarray
    faces: np.ndarray
    joints: np.ndarray
    weight_joints: np.ndarray
    weights: np.ndarray
    shapes: dict[str, tuple[np.ndarray, np.ndarray]]
    collision: np.ndarray
    materials: np.ndarray

    @property
    def floor(self) -> float:
        """Height of the soles in the rest pose, metres below the pelvis joint (a negative number)."""
        return float(self.vertices[:, 1].min())

    @property
    def height(self) -> float:
        """Distance from the soles to the top of the head, metres."""
        return float(np.ptp(self.vertices[:, 1]))

    def shaped(self, values: dict[str, float]) -> Human:
        """Return this body with shapes at values from 0 to 1; joints follow.

        The value of SIZE is by how much the whole body is larger, such as 0.1. Raises KeyError for an unknown name.
        """
        vertices, joints = self.vertices, self.joints
        for name, value in values.items():
            if name != SIZE:
                vertices = vertices + value * self.shapes[name][0]
                joints = joints + value * self.shapes[name][1]
        if values.get(SIZE):
            vertices, joints = ((1 + values[SIZE]) * points for points in (vertices, joints))
        return replace(self, vertices=_frozen(vertices), joints=_frozen(joints))

    def with_joints(self, joints: np.ndarray) -> Human:
        """Return this body, without shapes, with its joints at (55, 3); the skin follows by its weights."""
        shift = joints - joints[0] - self.joints
        moved = self.vertices + np.einsum("vk,vka->va", self.weights, shift[self.weight_joints])
        return replace(self, vertices=_frozen(moved), joints=_frozen(joints - joints[0]), shapes={})

    def blend_matrix(self, subset: np.ndarray | None = None) -> np.ndarray:
        """Return weight times (x, y, z, 1) for each joint, (55 * 4, V): skinning is one product with it.

        Single precision, read-only. subset: vertex indices (V,); all if left out.
        """
        return _blend_matrix(self, None if subset is None else np.asarray(subset, np.int64).tobytes())


@functools.lru_cache(maxsize=8)
def _blend_matrix(human: Human, subset: bytes | None) -> np.ndarray:
    """Compute Human.blend_matrix, cached for consecutive takes. subset: vertex indices as bytes, or None for all."""
    chosen = np.arange(len(human.vertices)) if subset is None else np.frombuffer(subset, np.int64)
    points = np.concatenate([human.vertices[chosen], np.ones((len(chosen), 1))], axis=1)
    table = np.zeros((len(skeleton.JOINTS), 4, len(chosen)))
    for k in range(4):
        np.add.at(
            table.transpose(0, 2, 1),
            (human.weight_joints[chosen, k], np.arange(len(chosen))),
            human.weights[chosen, k, None] * points,
        )
    return _frozen(table.reshape(-1, len(chosen)).astype(np.float32))


def _frozen(array: np.ndarray) -> np.ndarray:
    array.setflags(write=False)
    return array


@functools.cache
def load() -> Human:
    """Return the default human, shared and read-only. Raises SampError if its file is missing or damaged."""
    try:
        return _read()
    except (OSError, EOFError, KeyError, ValueError, zipfile.BadZipFile, zlib.error) as error:
        raise SampError(
            "The file of the default human is missing or damaged; install the add-on again."
        ) from error


def _read() -> Human:
    with np.load(ASSET) as data:
        unit = float(data["unit"])
        weights = data["weights"].astype(np.float64)
        joints = data["J"].astype(np.float64)
        shapes = {
            str(name): (_frozen(vertices * unit), _frozen(offsets.astype(np.float64)))
            for name, vertices, offsets in zip(
                data["shape_names"], data["shape_vertices"], data["shape_joints"], strict=True
            )
        }
        joints = joints - joints[0]
        vertices, faces = data["vertices"] * unit, data["faces"].astype(np.int64)
        materials = data["materials"].astype(np.int64)
        materials[brows.of(vertices, faces, joints)] = MATERIALS.index("hair")
        return Human(
            vertices=_frozen(vertices),
            faces=_frozen(faces),
            joints=_frozen(joints),
            weight_joints=_frozen(data["weight_joints"].astype(np.int64)),
            weights=_frozen(weights / weights.sum(1, keepdims=True)),
            shapes=shapes,
            collision=_frozen(data["collision"].astype(np.int64)),
            materials=_frozen(materials),
        )


def skin(human: Human, motion: Motion, subset: np.ndarray | None = None, chunk: int = 64) -> np.ndarray:
    """Compute the body's vertices in each frame: (T, V, 3) world, metres, network frame, single precision.

    The bone lengths are the human's, not the motion's; the pelvis joint is placed at the motion's root. subset: vertex
    indices, such as human.collision. chunk: frames processed together, which bounds the memory.
    """
    table = human.blend_matrix(subset)
    rotations = complete(motion.rotations)
    positions, globals_ = skeleton.forward_kinematics(np.zeros_like(motion.root), rotations, human.joints)
    matrices = rotation.quaternion_to_matrix(globals_)
    offsets = positions - np.einsum("tjab,jb->tja", matrices, human.joints)
    transforms = np.concatenate([matrices, offsets[..., None]], axis=-1).astype(np.float32)  # (T, 55, 3, 4)
    vertices = np.empty((len(motion), table.shape[1], 3), dtype=np.float32)
    for start in range(0, len(motion), chunk):
        part = transforms[start : start + chunk].transpose(0, 2, 1, 3).reshape(-1, table.shape[0])
        moved = (part @ table).reshape(-1, 3, table.shape[1])
        moved += motion.root[start : start + chunk, :, None]
        vertices[start : start + chunk] = moved.transpose(0, 2, 1)
    return vertices


def back_of(human: Human) -> np.ndarray:
    """Return the indices of the vertices of the back: those behind the spine that belong to it."""
    owner = np.take_along_axis(human.weight_joints, human.weights.argmax(1)[:, None], 1)[:, 0]
    behind = human.vertices[:, 2] < np.percentile(human.vertices[:, 2], 25)
    return np.flatnonzero(np.isin(owner, [skeleton.INDEX[name] for name in SPINE]) & behind)
