"""A common neutral posture for all captured subjects.

Each subject's retargeting has a constant tilt in pelvis, trunk and head, up to 30 degrees. A network trained on all of
them drifts from one to the other during a rollout and ends with an arched back.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace

import numpy as np

from ...samp_addon import rotation, skeleton
from .clip_files import Clip
from .events import headings

NEUTRAL = {"pelvis": 3.0, "spine3": 5.0, "head": 7.0}
"""Forward tilt, degrees, in walking and standing, as in the captures with the best fit of soles, hips and skull."""
UPRIGHT = ("walk", "idle", "shift")
STANDING = 0.8  # least height (m) of the pelvis over the floor
MULTI_SUBJECT_SETS = ("rb", "ac")
FEWEST = 20  # frames needed to estimate a posture
# Share of the corrections of pelvis, chest and head that each joint takes; arms and legs keep their directions.
SHARES = {
    "pelvis": (1, 0, 0), "spine1": (2 / 3, 1 / 3, 0), "spine2": (1 / 3, 2 / 3, 0), "spine3": (0, 1, 0),
    "left_collar": (0, 1, 0), "right_collar": (0, 1, 0), "neck": (0, 0.5, 0.5), "head": (0, 0, 1),
}  # fmt: skip


def subject(clip: Clip) -> str:
    """Return the subject of a clip: the first part of the name, or two parts for sets of several subjects."""
    parts = clip.name.split("_")
    return "_".join(parts[:2]) if parts[0] in MULTI_SUBJECT_SETS else parts[0]


def tilts(clip: Clip) -> np.ndarray:
    """Return the forward tilt (N, 3), degrees, of pelvis, chest and head in frames of walking or standing."""
    upright = np.isin(clip.labels, UPRIGHT) & (clip.root[:, 1] > STANDING) & ~clip.bad
    if not upright.any():
        return np.zeros((0, 3))
    root, quats = clip.root[upright], clip.rotations[upright]
    _, turned = skeleton.forward_kinematics(root, quats, skeleton.default_rest_joints())
    yaw = headings(root, quats)
    ahead = np.stack([np.sin(yaw), np.zeros_like(yaw), np.cos(yaw)], -1)
    up = rotation.quaternion_to_matrix(turned[:, [skeleton.INDEX[name] for name in NEUTRAL]])[..., 1]
    return np.degrees(np.arctan2((up * ahead[:, None]).sum(-1), up[..., 1]))


def neutralised(clips: list[Clip]) -> list[Clip]:
    """Return the clips with every subject's median posture shifted to NEUTRAL; feet and hips stay in place."""
    by_subject: dict[str, list[np.ndarray]] = defaultdict(list)
    for clip in clips:
        by_subject[subject(clip)].append(tilts(clip))
    off = {}
    for name, parts in by_subject.items():
        frames = np.concatenate(parts)
        if len(frames) >= FEWEST:
            off[name] = np.radians(np.median(frames, axis=0) - list(NEUTRAL.values()))
    return [corrected(clip, off[subject(clip)]) if subject(clip) in off else clip for clip in clips]


def corrected(clip: Clip, off: np.ndarray) -> Clip:
    """Return the clip with pelvis, chest and head tilted back by ``off`` (3,), radians."""
    rest = skeleton.default_rest_joints()
    joints, turned = skeleton.forward_kinematics(clip.root, clip.rotations, rest)
    for name, share in SHARES.items():
        back = rotation.from_axis_angle(np.array([-float(np.dot(share, off)), 0.0, 0.0]))
        j = skeleton.INDEX[name]
        turned[:, j] = rotation.multiply(turned[:, j], np.broadcast_to(back, turned[:, j].shape))
    rotations = rotation.continuous(skeleton.local_rotations(turned))
    hips = [skeleton.INDEX["left_hip"], skeleton.INDEX["right_hip"]]
    moved, _ = skeleton.forward_kinematics(clip.root, rotations, rest)
    root = clip.root + joints[:, hips].mean(1) - moved[:, hips].mean(1)
    return replace(clip, root=root, rotations=rotations)
