"""A rig laid over SMPL-X: which way it faces, its bones' directions against those of the T-pose, its proportions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .. import rotation, skeleton
from ..body.proportions import leg_length
from ..errors import SampError
from ..refine.feet.foot import BALL_HEIGHT
from . import maps, spines
from .rig import Rig

SNAP = np.radians(15.0)  # by which a body's axes may lean from the armature's and still mean them
SOLE = (0.02, 0.3)  # share of the leg that an ankle can be over the sole
NEAR_FOOT = 0.35  # share of the leg around an ankle in which its sole is looked for
SEAT_BAND = (-0.25, 0.03)  # shares of the leg over the hips between which a body touches its seat
SEAT_SIDE = 1.5  # hip joints' distances from the middle within which it does
_LIMB = {
    "hip": "knee",
    "knee": "ankle",
    "shoulder": "elbow",
    "elbow": "wrist",
} | {f"{finger}{k}": f"{finger}{k + 1}" for finger in maps.FINGERS for k in (1, 2)}
_BASE = {"knee": "hip", "elbow": "shoulder", "wrist": "elbow", "foot": "ankle"} | {
    f"{finger}{k}": f"{finger}{k - 1}" if k > 1 else "wrist" for finger in maps.FINGERS for k in (1, 2, 3)
}


@dataclass(frozen=True, eq=False)
class Fit:
    """How a rig relates to a body.

    axes: (3, 3) turns network axes into the armature's own, the rig facing +Z. joints: (55, 3) metres, network
    frame, the pelvis at the origin: where its joints are in SMPL-X's T-pose. The pelvis is as far over the hips
    as the body's; pelvis_bone: (3,) where the head of its bone is, anywhere along the trunk. sole: metres from
    the ankle joint down to the sole. seat: metres from the hips back to the skin, or None without skin.
    links: the bones that get keys, parents before children. parents: (K,) which link each of them turns with,
    -1 for none. aligned: (K, 4) quaternions, network frame, from the rest pose to the T-pose.
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
    """Lays a rig over a body with rest joints (55, 3). bones: joint -> bone of the rig.

    Raises SampError where bones are missing, or cannot be these joints.
    """
    at = _indices(rig, bones)
    axes = _axes(rig, at)
    heads = (rig.heads - rig.heads[at["pelvis"]]) @ axes * rig.scale
    places = {joint: heads[bone] for joint, bone in at.items()}
    turns = _alignment(places, rig, at, axes, body)
    links = _links(rig, at)
    skin = (rig.skin - rig.heads[at["pelvis"]]) @ axes * rig.scale
    ground = _ground(rig, at, axes, places, skin)
    joints = _in_t_pose(places, turns, body)
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
        parents=_parents(rig, links),
        aligned=np.array(aligned),
    )


def hips(joints: np.ndarray) -> np.ndarray:
    """The middle (..., 3) of the hip joints, of joints (..., J, 3)."""
    return (joints[..., skeleton.INDEX["left_hip"], :] + joints[..., skeleton.INDEX["right_hip"], :]) / 2


def seat_depth(skin: np.ndarray, joints: np.ndarray) -> float | None:
    """Metres from the middle of the hips back to the skin (N, 3) that rests on a seat; None without skin there.

    joints: (55, 3) in the T-pose, in the frame of the skin. Who sits has this below the hips.
    """
    leg = leg_length(joints)
    left, right = (joints[skeleton.INDEX[f"{side}_hip"]] for side in ("left", "right"))
    away = skin - hips(joints)
    near = (np.abs(away[:, 0]) < SEAT_SIDE * max(abs(left[0] - right[0]), 0.1 * leg)) & (
        (away[:, 1] > SEAT_BAND[0] * leg) & (away[:, 1] < SEAT_BAND[1] * leg)
    )
    if near.sum() < 8:
        return None
    depth = float(-np.percentile(away[near, 2], 2))
    return depth if 0.02 * leg < depth < 0.5 * leg else None


def _indices(rig: Rig, bones: Mapping[str, str]) -> dict[str, int]:
    """Joint -> index of its bone; raises SampError where one is missing, unknown or used twice."""
    lacking = [joint for joint in maps.ESSENTIAL if not bones.get(joint)]
    if lacking:
        raise SampError(f"No bone of '{rig.name}' is named for {', '.join(lacking)}; fill in the bone table.")
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
                f"The bone '{bone}' of '{rig.name}' stands for {used[bone]} and {joint}; choose one."
            )
        used[bone] = joint
        at[joint] = rig.index(bone)
    return at


def _axes(rig: Rig, at: Mapping[str, int]) -> np.ndarray:
    """The turn (3, 3) of network axes onto the armature's own: up from feet to head, left from right to left."""
    middle = lambda joint: (rig.heads[at[f"left_{joint}"]] + rig.heads[at[f"right_{joint}"]]) / 2
    up = _snapped(middle("shoulder") - middle("ankle"))
    side = sum(
        rig.heads[at[f"left_{joint}"]] - rig.heads[at[f"right_{joint}"]] for joint in ("hip", "shoulder")
    )
    side = side - (side @ up) * up
    if np.linalg.norm(side) < 1e-9:
        raise SampError(f"Left and right of '{rig.name}' are at the same place; correct its bone table.")
    side = _snapped(side)
    side = side - (side @ up) * up
    side /= np.linalg.norm(side)
    axes = np.stack([side, up, np.cross(side, up)], axis=1)
    toes = [
        rig.heads[at[f"{s}_foot"]] - rig.heads[at[f"{s}_ankle"]]
        for s in ("left", "right")
        if f"{s}_foot" in at
    ]
    if toes and sum(toes) @ axes[:, 2] < 0:
        raise SampError(
            f"The feet of '{rig.name}' point back; left and right are exchanged in its bone table."
        )
    return axes


def _snapped(direction: np.ndarray) -> np.ndarray:
    """The unit vector of a direction (3,), or the whole axis that it is near to."""
    unit = direction / np.linalg.norm(direction)
    k = int(np.argmax(np.abs(unit)))
    if np.abs(unit[k]) < np.cos(SNAP):
        return unit
    axis = np.zeros(3)
    axis[k] = np.sign(unit[k])
    return axis


def _alignment(
    places: Mapping[str, np.ndarray],
    rig: Rig,
    at: Mapping[str, int],
    axes: np.ndarray,
    body: np.ndarray,
) -> np.ndarray:
    """Quaternions (55, 4), network frame, that bring each joint's bone from the rest pose into the T-pose.

    Arms, legs and fingers by their directions, each on top of what turned the one before it; hands by their
    palms; feet about the vertical only, so that soles stay flat; the trunk as it is.
    """
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (len(skeleton.JOINTS), 1))
    for joint in _inwards_first():
        side, part = joint.split("_")
        base = turns[skeleton.INDEX[f"{side}_{_BASE[part]}"]] if part in _BASE else turns[0]
        turn = base
        if part == "ankle":
            turn = _about_vertical(_foot(side, places, rig, at, axes), _way(body, side, "ankle", "foot"))
        elif part == "wrist":
            turn = _palm(side, places, body, base)
        elif part in _LIMB and joint in places and f"{side}_{_LIMB[part]}" in places:
            own = places[f"{side}_{_LIMB[part]}"] - places[joint]
            turn = _onto(base, own, _way(body, side, part, _LIMB[part]))
        turns[skeleton.INDEX[joint]] = turn
    return turns


def _inwards_first() -> list[str]:
    """The joints of limbs and fingers, each after the one that it hangs from."""
    body = ("hip", "knee", "ankle", "foot", "shoulder", "elbow", "wrist")
    return [f"{side}_{part}" for side in ("left", "right") for part in body] + list(maps.HANDS)


def _way(joints: np.ndarray, side: str, start: str, end: str) -> np.ndarray:
    return joints[skeleton.INDEX[f"{side}_{end}"]] - joints[skeleton.INDEX[f"{side}_{start}"]]


def _onto(base: np.ndarray, own: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """The turn (4,) that does what base does, and then the least that brings a direction onto the wanted one."""
    return rotation.multiply(rotation.between(rotation.rotate(base, own), wanted), base)


def _about_vertical(own: np.ndarray | None, wanted: np.ndarray) -> np.ndarray:
    """The turn (4,) about the vertical that brings a foot's direction onto the wanted one."""
    if own is None:
        return np.array([1.0, 0.0, 0.0, 0.0])
    return rotation.about_y(np.arctan2(wanted[0], wanted[2]) - np.arctan2(own[0], own[2]))


def _foot(
    side: str, places: Mapping[str, np.ndarray], rig: Rig, at: Mapping[str, int], axes: np.ndarray
) -> np.ndarray | None:
    """Where a foot points (3,) in the rest pose: to its ball, or as its bone does; None where that is up or down."""
    if f"{side}_foot" in places:
        way = places[f"{side}_foot"] - places[f"{side}_ankle"]
    else:
        bone = at[f"{side}_ankle"]
        way = (rig.tails[bone] - rig.heads[bone]) @ axes
    flat = np.hypot(way[0], way[2])
    return way if flat > 0.3 * np.linalg.norm(way) and way[2] > 0 else None


def _palm(side: str, places: Mapping[str, np.ndarray], body: np.ndarray, base: np.ndarray) -> np.ndarray:
    """The turn (4,) of a hand: by its palm, if the roots of its fingers are known, else that of the forearm."""
    wrist, fingers = f"{side}_wrist", [f"{side}_{finger}1" for finger in ("middle", "index", "pinky")]
    if wrist not in places or any(joint not in places for joint in fingers):
        return base
    own = _hand_frame(places[wrist], *(places[joint] for joint in fingers))
    wanted = _hand_frame(*(body[skeleton.INDEX[joint]] for joint in (wrist, *fingers)))
    return rotation.matrix_to_quaternion(wanted @ own.T)


def _hand_frame(wrist: np.ndarray, middle: np.ndarray, index: np.ndarray, pinky: np.ndarray) -> np.ndarray:
    """Axes (3, 3) of a hand: along it, across it, through the palm."""
    along = (middle - wrist) / np.linalg.norm(middle - wrist)
    across = index - pinky
    across = across - (across @ along) * along
    across /= np.linalg.norm(across)
    return np.stack([along, across, np.cross(along, across)], axis=1)


def _links(rig: Rig, at: Mapping[str, int]) -> list[spines.Link]:
    """All bones that get keys, parents before children."""
    spine, neck = spines.spine_and_neck(rig, at)
    trunk = [spines.Link(at["pelvis"], "pelvis", "pelvis", 1.0), *spine, *neck]
    done = {link.bone for link in trunk}
    skipped = {"pelvis", "neck", *spines.SPINE}
    others = [
        spines.Link(at[joint], joint, joint, 1.0)
        for joint in maps.JOINTS
        if joint in at and joint not in skipped
    ]
    return trunk + [link for link in others if link.bone not in done]


def _parents(rig: Rig, links: list[spines.Link]) -> np.ndarray:
    """Which link each link turns with (K,): the first one above it or, where constraints lead from one to the
    other, the one of the joint before it; -1 for the pelvis and for bones that keep their own direction."""
    place = {link.bone: k for k, link in enumerate(links)}
    result = np.full(len(links), -1)
    for k, link in enumerate(links[1:], start=1):
        bone, machinery = link.bone, False
        while bone >= 0 and (bone == link.bone or bone not in place):
            if not rig.inherits[bone] and not machinery:
                break
            machinery |= bone != link.bone and bool(rig.constrained[bone])
            bone = int(rig.parents[bone])
        else:
            if machinery:
                result[k] = _before(links, k)
            elif bone >= 0:
                result[k] = place[bone]
            else:
                raise SampError(
                    f"The bone '{rig.names[link.bone]}' of '{rig.name}' does not hang from "
                    f"'{rig.names[links[0].bone]}', its pelvis; correct the bone table."
                )
    return result


def _before(links: list[spines.Link], k: int) -> int:
    """The link of the nearest joint before this link's, among links[:k]."""
    trunk = ("pelvis", *spines.SPINE, "neck")
    if links[k].above in trunk:
        return k - 1
    joint = skeleton.PARENTS[skeleton.INDEX[links[k].above]]
    while joint >= 0:
        name = skeleton.JOINTS[joint]
        found = [n for n, link in enumerate(links[:k]) if link.above == name]
        if found:
            return found[-1]
        joint = skeleton.PARENTS[joint]
    return 0


def _ground(
    rig: Rig, at: Mapping[str, int], axes: np.ndarray, places: Mapping[str, np.ndarray], skin: np.ndarray
) -> float:
    """Height of the ground under the rig in its rest pose, over the pelvis bone's head, metres: under its skin, or
    where the armature has its origin, or as far under the balls of the feet as our body's."""
    ankles = np.array([places[f"{side}_ankle"] for side in ("left", "right")])
    hips = np.array([places[f"{side}_hip"] for side in ("left", "right")])
    leg = float(np.linalg.norm(hips - ankles, axis=1).mean())
    low, high = (ankles[:, 1].mean() - share * leg for share in reversed(SOLE))
    if len(skin):
        away = np.linalg.norm((skin[:, None] - ankles)[..., [0, 2]], axis=-1).min(1)
        near = skin[(away < NEAR_FOOT * leg) & (skin[:, 1] < ankles[:, 1].mean())]
        if len(near) and low < near[:, 1].min() < high:
            return float(near[:, 1].min())
    balls = [places[joint][1] for joint in ("left_foot", "right_foot") if joint in places]
    origin = float(-(rig.heads[at["pelvis"]] @ axes[:, 1]) * rig.scale)
    if low < origin < high and all(origin < ball + 0.02 * leg for ball in balls):
        return origin
    own = leg / leg_length(skeleton.default_rest_joints())
    return float(min(balls, default=ankles[:, 1].mean() - 0.05 * own) - BALL_HEIGHT * own)


def _in_t_pose(places: Mapping[str, np.ndarray], turns: np.ndarray, body: np.ndarray) -> np.ndarray:
    """Joints (55, 3) of the rig in the T-pose, the pelvis bone's head at the origin; those without a bone where a
    body of the rig's size has them."""
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
        way = places[joint] - places[skeleton.JOINTS[above]]
        joints[j] = joints[above] + rotation.rotate(turns[above], way)
    return joints
