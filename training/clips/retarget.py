"""Retarget a recording to the default human: rotations by the mapping, scale by leg length, feet by inverse
kinematics."""

from __future__ import annotations

import numpy as np

from ...samp_addon import rotation, skeleton
from ...samp_addon.body.proportions import leg_length
from ...samp_addon.motion import Motion
from ...samp_addon.refine.inverse_kinematics import LIMBS, solve_limb
from ...samp_addon.rigs.fitting import hips
from .mapping import Mapping, places, rotations
from .recording import Recording
from .straightness import limb_lengths, limb_reach

FPS = 30.0
EASED, LONGEST = (
    0.991,
    0.9978,
)  # share of a limb's length from which a distant target is drawn in, and the limit that it approaches
NO_TWIST = np.radians(4.0)  # standard deviation of the forearm's twist below which the hand has all of it
HAND_SHARE = 0.5  # share of the hand's twist that is then moved to the forearm


def retargeted(recording: Recording, mapping: Mapping, leg: float = 1.0, arm: float = 1.0) -> Motion:
    """Return the recording at 30 frames a second on the default human; its floor stays at the file's height.

    leg, arm: corrections of the captured limbs' lengths (straightness.py). Positions are scaled to the default human's
    leg length; hips and ankles are then placed at the file's positions.
    """
    recording = recording.at_rate(FPS)
    rest = skeleton.default_rest_joints()
    joints = places(recording, mapping) * (leg * leg_length(rest) / mapping.leg)
    globals_ = rotations(recording, mapping)
    bones = mapping.bones
    middle = (joints[:, bones["left_hip"]] + joints[:, bones["right_hip"]]) / 2
    root = middle - rotation.rotate(globals_[:, 0], np.broadcast_to(hips(rest), middle.shape))
    local = rotation.normalise(skeleton.local_rotations(globals_))
    local = shared_twist(local, rest)
    for side in ("left", "right"):
        target = _ankle(recording, mapping, joints, root, globals_[:, 0], side, leg)
        local = reached(root, local, rest, f"{side}_leg", target)
        if arm > 1.0:
            made, _ = skeleton.forward_kinematics(root, local, rest)
            start, end = (made[:, skeleton.INDEX[f"{side}_{part}"]] for part in ("shoulder", "wrist"))
            local = reached(root, local, rest, f"{side}_arm", start + (end - start) * arm)
    return Motion(root, rotation.continuous(local), FPS)


def _ankle(
    recording: Recording, mapping: Mapping, joints: np.ndarray, root: np.ndarray, pelvis: np.ndarray,
    side: str, leg: float,
) -> np.ndarray:  # fmt: skip
    """Return an ankle's target (T, 3): towards its scaled position, at the distance that preserves the knee's flexion.

    The two differ by millimetres, because hip width and leg length differ between bodies, and a millimetre is a degree
    in a nearly straight knee.
    """
    rest = skeleton.default_rest_joints()
    hip = skeleton.INDEX[f"{side}_hip"]
    start = root + rotation.rotate(pelvis, np.broadcast_to(rest[hip], root.shape))
    way = joints[:, mapping.bones[f"{side}_ankle"]] - start
    limb = LIMBS[f"{side}_leg"]
    own = sum(limb_lengths(rest, [skeleton.INDEX[name] for name in limb]))
    ratio = limb_reach(recording, mapping, f"{side}_leg") * leg
    return start + way * (ratio * own / np.maximum(np.linalg.norm(way, axis=-1), 1e-9))[:, None]


def reached(
    root: np.ndarray, local: np.ndarray, rest: np.ndarray, limb: str, target: np.ndarray
) -> np.ndarray:
    """Return local rotations (T, J, 4) with a limb's end at target (T, 3); targets near full reach are drawn in."""
    a, b, c = (skeleton.INDEX[name] for name in LIMBS[limb])
    length = np.linalg.norm(rest[b] - rest[a]) + np.linalg.norm(rest[c] - rest[b])
    joints, _ = skeleton.forward_kinematics(root, local, rest)
    way = target - joints[:, a]
    far = np.linalg.norm(way, axis=-1, keepdims=True)
    soft, room = EASED * length, (LONGEST - EASED) * length
    drawn = soft + room * (1 - np.exp(-np.maximum(far - soft, 0.0) / room))
    way = way * np.where(far > soft, drawn / np.maximum(far, 1e-9), 1.0)
    return solve_limb(root, local, rest, limb, joints[:, a] + way)


def shared_twist(local: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """Return local rotations (T, J, 4) with half of the hands' twist moved to forearms that never twist themselves.

    Where the hand alone twists, the skin of the wrist collapses.
    """
    local = local.copy()
    for side in ("left", "right"):
        elbow, wrist = skeleton.INDEX[f"{side}_elbow"], skeleton.INDEX[f"{side}_wrist"]
        axis = rest[wrist] - rest[elbow]
        axis = axis / np.linalg.norm(axis)
        if np.std(twist(local[:, elbow], axis)) > NO_TWIST:
            continue
        part = rotation.from_axis_angle(HAND_SHARE * twist(local[:, wrist], axis)[:, None] * axis)
        local[:, elbow] = rotation.multiply(local[:, elbow], part)
        local[:, wrist] = rotation.multiply(rotation.conjugate(part), local[:, wrist])
    return local


def twist(quaternions: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Return the angle (T,), radians from -pi to pi, by which rotations (T, 4) turn about a unit axis (3,)."""
    along = quaternions[..., 1:] @ axis
    angle = 2 * np.arctan2(along, quaternions[..., 0])
    return (angle + np.pi) % (2 * np.pi) - np.pi
