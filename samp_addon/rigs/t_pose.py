"""A rig in the T-pose of SMPL-X: how its bones turn to get there, and where its joints are then."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .. import rotation, skeleton
from . import maps
from .rig import Rig

_LIMB = {
    "hip": "knee",
    "knee": "ankle",
    "shoulder": "elbow",
    "elbow": "wrist",
} | {f"{finger}{k}": f"{finger}{k + 1}" for finger in maps.FINGERS for k in (1, 2)}
_BASE = {"knee": "hip", "elbow": "shoulder", "wrist": "elbow", "foot": "ankle"} | {
    f"{finger}{k}": f"{finger}{k - 1}" if k > 1 else "wrist" for finger in maps.FINGERS for k in (1, 2, 3)
}


def align_to_t_pose(
    places: Mapping[str, np.ndarray],
    rig: Rig,
    at: Mapping[str, int],
    axes: np.ndarray,
    body: np.ndarray,
) -> np.ndarray:
    """Return the quaternions (55, 4), network frame, that turn each joint's bone from the rest pose into the T-pose.

    Arms, legs and fingers are turned by their directions, each after its parent; hands by their palms; feet about the
    vertical only, so that soles stay flat; the trunk not at all. places: joint -> (3,) in the rest pose, network frame.
    at: joint -> index of its bone. axes: see body_axes. body: (55, 3) rest joints of SMPL-X.
    """
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (len(skeleton.JOINTS), 1))
    for joint in _parents_first():
        side, part = joint.split("_")
        base = turns[skeleton.INDEX[f"{side}_{_BASE[part]}"]] if part in _BASE else turns[0]
        turn = base
        if part == "ankle":
            turn = _yaw_onto(
                _foot_direction(side, places, rig, at, axes), _direction(body, side, "ankle", "foot")
            )
        elif part == "wrist":
            turn = _turn_palm(side, places, body, base)
        elif part in _LIMB and joint in places and f"{side}_{_LIMB[part]}" in places:
            own = places[f"{side}_{_LIMB[part]}"] - places[joint]
            turn = _turn_onto(base, own, _direction(body, side, part, _LIMB[part]))
        turns[skeleton.INDEX[joint]] = turn
    return turns


def _parents_first() -> list[str]:
    """Return the joints of limbs and fingers, each after its parent."""
    body = ("hip", "knee", "ankle", "foot", "shoulder", "elbow", "wrist")
    return [f"{side}_{part}" for side in ("left", "right") for part in body] + list(maps.HANDS)


def _direction(joints: np.ndarray, side: str, start: str, end: str) -> np.ndarray:
    """Return the vector (3,) between two joints of one side. joints: (55, 3)."""
    return joints[skeleton.INDEX[f"{side}_{end}"]] - joints[skeleton.INDEX[f"{side}_{start}"]]


def _turn_onto(base: np.ndarray, own: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Return base (4,), followed by the smallest turn that brings a direction onto the wanted one."""
    return rotation.multiply(rotation.between(rotation.rotate(base, own), wanted), base)


def _yaw_onto(own: np.ndarray | None, wanted: np.ndarray) -> np.ndarray:
    """Return the turn (4,) about the vertical that brings a direction onto the wanted one; none for None."""
    if own is None:
        return np.array([1.0, 0.0, 0.0, 0.0])
    return rotation.about_y(np.arctan2(wanted[0], wanted[2]) - np.arctan2(own[0], own[2]))


def _foot_direction(
    side: str, places: Mapping[str, np.ndarray], rig: Rig, at: Mapping[str, int], axes: np.ndarray
) -> np.ndarray | None:
    """Return the direction (3,) of a foot in the rest pose: to its ball, else that of its bone; None if vertical."""
    if f"{side}_foot" in places:
        toes = places[f"{side}_foot"] - places[f"{side}_ankle"]
    else:
        bone = at[f"{side}_ankle"]
        toes = (rig.tails[bone] - rig.heads[bone]) @ axes
    flat = np.hypot(toes[0], toes[2])
    return toes if flat > 0.3 * np.linalg.norm(toes) and toes[2] > 0 else None


def _turn_palm(side: str, places: Mapping[str, np.ndarray], body: np.ndarray, base: np.ndarray) -> np.ndarray:
    """Return the turn (4,) of a hand: by its palm if the roots of its fingers are known, else that of the forearm."""
    wrist, fingers = f"{side}_wrist", [f"{side}_{finger}1" for finger in ("middle", "index", "pinky")]
    if wrist not in places or any(joint not in places for joint in fingers):
        return base
    own = _hand_frame(places[wrist], *(places[joint] for joint in fingers))
    wanted = _hand_frame(*(body[skeleton.INDEX[joint]] for joint in (wrist, *fingers)))
    return rotation.matrix_to_quaternion(wanted @ own.T)


def _hand_frame(wrist: np.ndarray, middle: np.ndarray, index: np.ndarray, pinky: np.ndarray) -> np.ndarray:
    """Return the axes (3, 3) of a hand: along it, across it, through the palm."""
    along = (middle - wrist) / np.linalg.norm(middle - wrist)
    across = index - pinky
    across = across - (across @ along) * along
    across /= np.linalg.norm(across)
    return np.stack([along, across, np.cross(along, across)], axis=1)


def joints_in_t_pose(places: Mapping[str, np.ndarray], turns: np.ndarray, body: np.ndarray) -> np.ndarray:
    """Return the joints (55, 3) of a rig in the T-pose, the head of the pelvis bone at the origin.

    Joints without a bone are placed as in a body of the rig's size. turns: (55, 4) of align_to_t_pose.
    """
    size = np.linalg.norm(places["left_hip"] - places["left_knee"]) / np.linalg.norm(
        body[skeleton.INDEX["left_hip"]] - body[skeleton.INDEX["left_knee"]]
    )
    joints = np.zeros((len(skeleton.JOINTS), 3))
    for j, joint in enumerate(skeleton.JOINTS[1:], start=1):
        above = skeleton.PARENTS[j]
        if joint not in places:
            joints[j] = joints[above] + size * (body[j] - body[above])
            continue
        while skeleton.JOINTS[above] not in places:
            above = skeleton.PARENTS[above]
        bone = places[joint] - places[skeleton.JOINTS[above]]
        joints[j] = joints[above] + rotation.rotate(turns[above], bone)
    return joints
