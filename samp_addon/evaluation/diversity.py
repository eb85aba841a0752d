"""Diversity of takes (APD, SAMP equation 6) and their Frechet distance to real motion (equation 9).

The paper's APD pools the frames of all takes, so that ten identical takes are as diverse as one is in time; it is kept
for comparison with its tables. `diversity_in_time` compares takes frame by frame and is 0 for identical ones.

Features are expressed in the root frame: origin at the pelvis projected onto the floor, rotated by the heading.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import linalg

from .. import rotation
from ..frames import direction_yaw
from ..motion import Motion, velocities
from ..skeleton import BODY_COUNT

TRAJECTORY_SAMPLES = np.linspace(-1, 1, 13)
"""Times at which the root's trajectory is sampled, seconds relative to a frame."""

STEPS = 60
"""Equal steps of each phase, at which takes are compared."""

RESTING = 0.03
"""Metres of height around its last one within which a pelvis rests."""


def pose_features(motion: Motion) -> np.ndarray:
    """Return (T, 264): 22 joints x (position 3, forward 3, up 3, velocity 3) in each frame's root frame."""
    joints, globals_ = motion.forward_kinematics()
    joints, globals_ = joints[:, :BODY_COUNT], globals_[:, :BODY_COUNT]
    to_root = rotation.about_y(-direction_yaw(motion.headings()))[:, None]
    floor = motion.root * [1.0, 0.0, 1.0]
    matrices = rotation.quaternion_to_matrix(globals_)
    world = [joints - floor[:, None], matrices[..., 2], matrices[..., 1], velocities(joints, motion.fps)]
    local = [rotation.rotate(np.broadcast_to(to_root, (*part.shape[:2], 4)), part) for part in world]
    return np.stack(local, axis=2).reshape(len(motion), -1)


def trajectory_features(motion: Motion) -> np.ndarray:
    """Return (T, 52): the root's floor positions and directions at 13 times from -1 s to +1 s, in the root frame."""
    yaw = direction_yaw(motion.headings())
    steps = np.round(TRAJECTORY_SAMPLES * motion.fps).astype(int)
    at = np.clip(np.arange(len(motion))[:, None] + steps, 0, len(motion) - 1)
    offset = (motion.root[at] - motion.root[:, None])[..., [0, 2]]
    cosine, sine = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
    turned = np.stack(
        [cosine * offset[..., 0] - sine * offset[..., 1], sine * offset[..., 0] + cosine * offset[..., 1]], -1
    )
    relative = yaw[at] - yaw[:, None]
    return np.concatenate([turned, np.sin(relative)[..., None], np.cos(relative)[..., None]], -1).reshape(
        len(motion), -1
    )


def average_pairwise_distance(features: np.ndarray) -> float:
    """Return the APD of features (N, D), the mean squared distance of all pairs (equation 6); 0 for fewer than two.

    It is computed as twice the unbiased variance, summed over the features.
    """
    if len(features) < 2:
        return 0.0
    return float(2 * np.var(features, axis=0, ddof=1).sum())


def diversity(motions: Sequence[Motion]) -> float:
    """Return the paper's APD of the local poses of several takes of the same job, pooled over time."""
    return average_pairwise_distance(np.concatenate([pose_features(m) for m in motions]))


def phases(motion: Motion) -> list[slice]:
    """Return the frames of walking, of sitting or lying down, and of resting; all of a take that does not rest.

    A body rests from the frame after which its pelvis stays within 3 cm of its last height.
    """
    begun = motion.interaction_start
    if begun is None:
        return [slice(0, len(motion))]
    off = np.abs(motion.root[:, 1] - motion.root[-1, 1]) > RESTING
    last = int(np.flatnonzero(off)[-1]) + 1 if off.any() else 0
    rest = min(max(last, begun), len(motion) - 1)
    return [slice(0, begun), slice(begun, rest), slice(rest, len(motion))]


def aligned_features(motion: Motion) -> np.ndarray:
    """Return the local poses at STEPS equal steps of each phase, (S, 264), without the pelvis' place and facing."""
    features = pose_features(motion).reshape(len(motion), BODY_COUNT, 4, 3)
    features[:, :, 0] -= features[:, :1, 0].copy()
    features = features.reshape(len(motion), -1)
    rows = []
    for part in phases(motion):
        last = max(part.stop - 1, part.start)
        rows.append(np.linspace(min(part.start, last), last, STEPS))
    at = np.concatenate(rows)
    low = np.minimum(at.astype(int), max(len(motion) - 2, 0))
    share = (at - low)[:, None]
    return (1 - share) * features[low] + share * features[np.minimum(low + 1, len(motion) - 1)]


def diversity_in_time(motions: Sequence[Motion]) -> float:
    """Return the APD between takes of the same job, aligned in time; 0 for identical takes and for fewer than two.

    The mean over the steps of all phases of the mean squared distance of all pairs of takes.
    """
    if len(motions) < 2:
        return 0.0
    features = [aligned_features(motion) for motion in motions]
    steps = min(map(len, features))
    stacked = np.stack([one[-steps:] for one in features], axis=1)
    return float(np.mean([average_pairwise_distance(step) for step in stacked]))


def frechet_distance(ours: np.ndarray, real: np.ndarray) -> float:
    """Return the Frechet distance of two sets of features (N, D) and (M, D), each modelled as a normal distribution."""
    gap = ours.mean(0) - real.mean(0)
    a, b = np.atleast_2d(np.cov(ours.T)), np.atleast_2d(np.cov(real.T))
    # Only the eigenvalues of the product are needed; both factors are symmetric, so these are real and not negative.
    root = linalg.sqrtm(a)
    inner = np.linalg.eigvalsh(root.real @ b @ root.real)
    trace = np.trace(a) + np.trace(b) - 2 * np.sqrt(np.maximum(inner, 0)).sum()
    return float(max(gap @ gap + trace, 0.0))


def motion_distance(ours: Sequence[Motion], real: Sequence[Motion]) -> float:
    """Return the Frechet distance between takes and real motion, for the features of equation 9."""

    def features(motions: Sequence[Motion]) -> np.ndarray:
        return np.concatenate([np.hstack([pose_features(m), trajectory_features(m)]) for m in motions])

    return frechet_distance(features(ours), features(real))
