"""The 55 SMPL-X joints, their hierarchy, and forward kinematics."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np

from . import rotation

BODY_JOINTS = (
    "pelvis", "left_hip", "right_hip", "spine1", "left_knee", "right_knee", "spine2", "left_ankle", "right_ankle",
    "spine3", "left_foot", "right_foot", "neck", "left_collar", "right_collar", "head", "left_shoulder",
    "right_shoulder", "left_elbow", "right_elbow", "left_wrist", "right_wrist",
)  # fmt: skip
_FINGERS = tuple(
    f"{finger}{k}" for finger in ("index", "middle", "pinky", "ring", "thumb") for k in (1, 2, 3)
)
JOINTS = (
    BODY_JOINTS
    + ("jaw", "left_eye_smplhf", "right_eye_smplhf")
    + tuple(f"left_{name}" for name in _FINGERS)
    + tuple(f"right_{name}" for name in _FINGERS)
)
PARENTS = np.array(
    [-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19, 15, 15, 15]
    + [20, 25, 26, 20, 28, 29, 20, 31, 32, 20, 34, 35, 20, 37, 38]
    + [21, 40, 41, 21, 43, 44, 21, 46, 47, 21, 49, 50, 21, 52, 53]
)
INDEX = {name: i for i, name in enumerate(JOINTS)}
BODY_COUNT = len(BODY_JOINTS)


@functools.cache
def default_rest_joints() -> np.ndarray:
    """Return rest joint positions (55, 3) of the default human, pelvis at the origin, metres, network frame.

    The array is shared and read-only.
    """
    with np.load(Path(__file__).parent / "body" / "human.npz") as data:
        joints = data["J"].astype(np.float64)
    joints = joints - joints[0]
    joints.setflags(write=False)
    return joints


def mirror_joints() -> np.ndarray:
    """Return, for each of the 22 body joints, the index of its mirror image (22,)."""
    swap = {"left": "right", "right": "left"}
    return np.array(
        [
            INDEX["_".join([swap.get(n.split("_")[0], n.split("_")[0]), *n.split("_")[1:]])]
            for n in BODY_JOINTS
        ]
    )


def forward_kinematics(
    root: np.ndarray, rotations: np.ndarray, rest_joints: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Compute joint positions and global rotations of poses.

    root: (T, 3) pelvis position, metres. rotations: (T, J, 4) local quaternions, J <= 55.
    rest_joints: (J or more, 3). Returns positions (T, J, 3) and global quaternions (T, J, 4).
    """
    count = rotations.shape[1]
    local = np.ascontiguousarray(np.asarray(rotations, dtype=np.float64).T)  # (4, J, T)
    bones = (rest_joints[:count] - rest_joints[np.maximum(PARENTS[:count], 0)]).T[..., None]
    globals_, positions = np.empty_like(local), np.empty((3, *local.shape[1:]))
    globals_[:, 0], positions[:, 0] = local[:, 0], np.asarray(root).T
    for joints in _levels(count):
        parents = globals_[:, PARENTS[joints]]
        globals_[:, joints] = rotation.multiply_components(parents, local[:, joints])
        positions[:, joints] = positions[:, PARENTS[joints]] + rotation.rotate_components(
            parents, bones[:, joints]
        )
    return np.ascontiguousarray(positions.T), np.ascontiguousarray(globals_.T)


@functools.cache
def _levels(count: int) -> tuple[np.ndarray, ...]:
    """Group the first ``count`` joints by their depth in the hierarchy, without the pelvis."""
    depth = np.zeros(count, int)
    for j in range(1, count):
        depth[j] = depth[PARENTS[j]] + 1
    return tuple(np.flatnonzero(depth == level) for level in range(1, depth.max() + 1))


def local_rotations(globals_: np.ndarray) -> np.ndarray:
    """Return local quaternions (T, J, 4) of global ones (T, J, 4)."""
    parents = PARENTS[: globals_.shape[1]]
    local = rotation.multiply(rotation.conjugate(globals_[:, parents]), globals_)
    local[:, 0] = globals_[:, 0]
    return local
