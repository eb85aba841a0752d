"""Map the joints of a captured skeleton to SMPL-X's, with the rotation between the two in a rest pose.

With A the axes in which the skeleton's rest pose faces +Z, U the rotation of a bone from its rest pose and T the
rotation that brings the rest pose's limb onto SMPL-X's T-pose, the SMPL-X joint's rotation is (A^-1 U A) T^-1, where
only U varies. The result depends neither on the rest pose, nor on a bone's own axes, nor on the unit of length.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...samp_addon import rotation, skeleton
from ...samp_addon.body.proportions import leg_length
from ...samp_addon.errors import SampError
from ...samp_addon.rigs import fitting, guessing, maps, spines
from ...samp_addon.rigs.rig import Rig
from .recording import Recording

SPINE = ("spine1", "spine2", "spine3")
INSTEAD = {"collar": "spine3", "wrist": "elbow", "foot": "ankle", "neck": "spine3", "head": "neck"}
"""Joints that a skeleton may lack, and those whose rotation they copy."""

UPRIGHT = np.cos(np.radians(35.0))  # least cosine between limbs or trunk of a rest pose and its vertical
STRAIGHT = 0.97  # least distance from hip to ankle over the leg's length in a pose used as rest pose
STILL = 0.2  # highest speed of the pelvis in such a pose, leg lengths a second
_ACCLAIM = {"pelvis": "root", "spine1": "lowerback", "spine2": "upperback", "spine3": "thorax", "neck": "lowerneck",
            "head": "head", "hip": "{}femur", "knee": "{}tibia", "ankle": "{}foot", "foot": "{}toes",
            "collar": "{}clavicle", "shoulder": "{}humerus", "elbow": "{}radius", "wrist": "{}hand"}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Mapping:
    """A map from a captured skeleton to SMPL-X's.

    bones: joint -> index. below, above: (22,) indices of bones; share: (22,) from 0 to 1: a joint's rotation is
    interpolated between the two. axes: (3, 3) from network axes to the file's. aligned: (22, 4) quaternions, network
    frame, from the rest pose to the T-pose. leg: length of a leg in the file's unit.
    """

    bones: dict[str, int]
    below: np.ndarray
    above: np.ndarray
    share: np.ndarray
    axes: np.ndarray
    aligned: np.ndarray
    leg: float


def joints_of(recording: Recording) -> dict[str, int]:
    """Return joint -> index of its bone.

    Bones are identified by the names of known skeletons, else by words in names, else by hierarchy and position. Raise
    SampError where pelvis, legs or arms cannot be identified.
    """
    names = recording.names
    acclaim = {f"{side}_{part}" if "{}" in bone else part: bone.format(side[0])
               for part, bone in _ACCLAIM.items() for side in ("left", "right")}  # fmt: skip
    if set(acclaim.values()) <= set(names):
        found = acclaim
    else:
        known = maps.recognise(names)
        found = known[1] if known else guessing.guess(names, recording.parents, recording.rest)
    lacking = [joint for joint in maps.ESSENTIAL if joint not in found]
    if lacking:
        raise SampError(f"No joint of '{recording.name}' is recognised as {', '.join(lacking)}.")
    return {joint: names.index(bone) for joint, bone in found.items() if joint in skeleton.BODY_JOINTS}


def mapped(recordings: Sequence[Recording]) -> tuple[list[Recording], Mapping]:
    """Return the recordings of one skeleton with a common rest pose, and the map of that skeleton.

    The rest pose is the first that stands upright; else the first frame of a file that does (many begin in a T-pose);
    else the straightest still pose of all. Raise SampError without one.
    """
    first = recordings[0]
    bones = joints_of(first)
    pose = next(((one.rest, one.rest_turns) for one in recordings if stands(one.rest, bones)), None)
    if pose is None:
        pose = _standing_pose(recordings, bones)
    if pose is None:
        raise SampError(f"'{first.name}' has neither a rest pose nor a frame with an upright body.")
    recordings = [one.rested_at(*pose) for one in recordings]
    return recordings, _mapping(recordings[0], bones)


def stands(joints: np.ndarray, bones: dict[str, int]) -> bool:
    """Return whether joints (J, 3) form an upright body: legs straight under the trunk, feet forwards."""
    at = lambda joint: joints[bones[joint]]
    middle = lambda joint: (at(f"left_{joint}") + at(f"right_{joint}")) / 2
    up = middle("shoulder") - middle("ankle")
    up = up / max(np.linalg.norm(up), 1e-9)
    across = at("left_hip") - at("right_hip")
    directions = [middle("shoulder") - middle("hip")]
    for side in ("left", "right"):
        thigh = at(f"{side}_hip") - at(f"{side}_knee")
        shin = at(f"{side}_knee") - at(f"{side}_ankle")
        directions += [thigh, shin]
        if np.linalg.norm(thigh + shin) < STRAIGHT * (np.linalg.norm(thigh) + np.linalg.norm(shin)):
            return False
        if f"{side}_foot" in bones and (at(f"{side}_foot") - at(f"{side}_ankle")) @ np.cross(across, up) < 0:
            return False
    lengths = [max(np.linalg.norm(one), 1e-9) for one in directions]
    return all(one @ up > UPRIGHT * length for one, length in zip(directions, lengths, strict=True))


def _standing_pose(
    recordings: Sequence[Recording], bones: dict[str, int]
) -> tuple[np.ndarray, np.ndarray] | None:
    """Return joints (J, 3) and turns (J, 4) of a pose that can replace the rest pose; None where no frame stands."""
    for one in recordings:
        if stands(one.positions[0], bones):
            return one.positions[0], one.turns[0]
    best = None
    for one in recordings:
        legs = np.stack([_leg(one.positions, bones, side) for side in ("left", "right")])
        length = legs[..., 1].mean()
        straight = (legs[..., 0] / np.maximum(legs[..., 1], 1e-9)).min(0)
        moved = np.gradient(one.positions[:, bones["pelvis"]], 1 / one.fps, axis=0)
        straight = np.where(np.linalg.norm(moved, axis=-1) < STILL * length, straight, 0.0)
        for k in np.argsort(-straight)[:20]:
            if stands(one.positions[k], bones):
                if best is None or straight[k] > best[0]:
                    best = straight[k], one.positions[k], one.turns[k]
                break
    return None if best is None else best[1:]


def _leg(positions: np.ndarray, bones: dict[str, int], side: str) -> np.ndarray:
    """Return the distance from hip to ankle, and the length along thigh and shin (T, 2)."""
    hip, knee, ankle = (positions[:, bones[f"{side}_{part}"]] for part in ("hip", "knee", "ankle"))
    norm = lambda v: np.linalg.norm(v, axis=-1)
    return np.stack([norm(ankle - hip), norm(knee - hip) + norm(ankle - knee)], -1)


def _mapping(recording: Recording, bones: dict[str, int]) -> Mapping:
    rig = _rig(recording)
    fit = fitting.fit(
        rig, {joint: recording.names[k] for joint, k in bones.items()}, skeleton.default_rest_joints()
    )
    # fit's rotations belong to links, and none to the trunk, which stays as in the rest pose.
    aligned = np.tile([1.0, 0.0, 0.0, 0.0], (skeleton.BODY_COUNT, 1))
    for link, turn in zip(fit.links, fit.aligned, strict=True):
        if link.share == 1.0 and link.above in skeleton.BODY_JOINTS:
            aligned[skeleton.INDEX[link.above]] = turn
    below, above, share = _spread(rig, bones)
    for part in ("wrist", "foot"):
        for side in ("left", "right"):
            if f"{side}_{part}" not in bones:
                lent = skeleton.INDEX[f"{side}_{INSTEAD[part]}"]
                aligned[skeleton.INDEX[f"{side}_{part}"]] = aligned[lent]
    return Mapping(bones, below, above, share, fit.axes, aligned, leg_length(fit.joints))


def _rig(recording: Recording) -> Rig:
    count = len(recording.names)
    return Rig(
        name=recording.name, names=recording.names, parents=recording.parents, heads=recording.rest,
        tails=recording.tips, bases=np.tile(np.eye(3), (count, 1, 1)), constrained=np.zeros(count, bool),
        inherits=np.ones(count, bool), world=np.eye(4), turn=np.eye(3), scale=1.0,
    )  # fmt: skip


def _spread(rig: Rig, bones: dict[str, int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return, for each joint (22,), the two bones between which it is interpolated, and the share of the second.

    SMPL-X's three spine joints are spread evenly over the skeleton's spine of any length.
    """
    spine, neck = spines.spine_and_neck(rig, bones)
    trunk = [bones["pelvis"], *(link.bone for link in spine)]
    at: dict[str, tuple[int, int, float]] = {joint: (bone, bone, 1.0) for joint, bone in bones.items()}
    for k, joint in enumerate(SPINE, start=1):
        place = k * (len(trunk) - 1) / len(SPINE)
        low = min(int(place), max(len(trunk) - 2, 0))
        at[joint] = (trunk[low], trunk[min(low + 1, len(trunk) - 1)], place - low)
    if neck:
        at["neck"] = (neck[-1].bone, neck[-1].bone, 1.0)
    for joint in skeleton.BODY_JOINTS:
        if joint not in at:
            part = joint.split("_")[-1]
            lent = (
                INSTEAD[part]
                if part in ("collar", "neck", "head")
                else f"{joint[: -len(part)]}{INSTEAD[part]}"
            )
            at[joint] = at[lent]
    every = [at[joint] for joint in skeleton.BODY_JOINTS]
    return (np.array([one[0] for one in every]), np.array([one[1] for one in every]),
            np.array([one[2] for one in every]))  # fmt: skip


def places(recording: Recording, mapping: Mapping) -> np.ndarray:
    """Return joint positions (T, J, 3) in network axes, in the file's unit."""
    return recording.positions @ mapping.axes


def rotations(recording: Recording, mapping: Mapping) -> np.ndarray:
    """Return global rotations (T, 22, 4) of the SMPL-X joints, network frame."""
    turns = rotation.change_basis(recording.unfolded(), mapping.axes.T)
    spread = rotation.slerp(turns[:, mapping.below], turns[:, mapping.above], mapping.share)
    return rotation.multiply(spread, rotation.conjugate(mapping.aligned))
