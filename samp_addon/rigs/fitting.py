"""Fit of a rig to SMPL-X: its axes, its proportions in the T-pose, and the turns of its bones to get there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .. import skeleton
from ..body.proportions import leg_length
from ..errors import SampError
from ..refine.proportions.hips import hips, seat_depth
from . import maps, spines
from .landmarks import ground_height
from .links import key_links, link_parents
from .rig import Rig
from .rig_axes import body_axes
from .t_pose import align_to_t_pose, joints_in_t_pose


@dataclass(frozen=True, eq=False)
class Fit:
    """Fit of a rig to a body; network frame, metres.

    axes: (3, 3) rotation from network axes to the armature's own, with the rig facing +Z. joints: (55, 3) of the rig in
    SMPL-X's T-pose, the pelvis at the origin; the pelvis is as far over the hips as the body's. pelvis_bone: (3,) head
    of the pelvis bone, which can be anywhere along the trunk. sole: from the ankle joint down to the sole. seat: from
    the hips back to the skin, or None without skin. links: K bones that get keys, parents before children. parents:
    (K,) index of the link that each of them turns with, or -1. aligned: (K, 4) quaternions from the rest pose to the
    T-pose.
    """

    axes: np.ndarray
    joints: np.ndarray
    pelvis_bone: np.ndarray
    sole: float
    seat: float | None
    links: tuple[spines.Link, ...]
    parents: np.ndarray
    aligned: np.ndarray


def fit(rig: Rig, bones: Mapping[str, str], body: np.ndarray) -> Fit:
    """Fit a rig to a body with rest joints (55, 3). bones: joint -> name of its bone.

    Raises SampError where bones are missing, or cannot be those of these joints.
    """
    at = _indices(rig, bones)
    axes = body_axes(rig, at)
    heads = (rig.heads - rig.heads[at["pelvis"]]) @ axes * rig.scale
    places = {joint: heads[bone] for joint, bone in at.items()}
    turns = align_to_t_pose(places, rig, at, axes, body)
    links = key_links(rig, at)
    skin = (rig.skin - rig.heads[at["pelvis"]]) @ axes * rig.scale
    ground = ground_height(rig, at, axes, places, skin)
    joints = joints_in_t_pose(places, turns, body)
    pelvis = hips(joints) - leg_length(joints) / leg_length(body) * hips(body)
    joints[1:] -= pelvis
    ankle = np.mean([places[f"{side}_ankle"][1] for side in ("left", "right")])
    aligned = [turns[skeleton.INDEX[link.above]] for link in links]
    return Fit(
        axes=axes,
        joints=joints,
        pelvis_bone=-pelvis,
        sole=float(ankle - ground),
        seat=seat_depth(skin - pelvis, joints),
        links=tuple(links),
        parents=link_parents(rig, links),
        aligned=np.array(aligned),
    )


def _indices(rig: Rig, bones: Mapping[str, str]) -> dict[str, int]:
    """Return joint -> index of its bone. Raise SampError where one is missing, unknown or used twice."""
    lacking = [joint for joint in maps.ESSENTIAL if not bones.get(joint)]
    if lacking:
        raise SampError(f"'{rig.name}' has no bone for {', '.join(lacking)}; fill in the bone table.")
    at, used = {}, {}
    for joint, bone in bones.items():
        if not bone:
            continue
        if bone not in rig.names:
            raise SampError(
                f"'{rig.name}' has no bone '{bone}' for {joint}; choose another in the bone table."
            )
        if bone in used:
            raise SampError(
                f"The bone '{bone}' of '{rig.name}' is assigned to both {used[bone]} and {joint}; choose one."
            )
        used[bone] = joint
        at[joint] = rig.index(bone)
    return at
