"""Grasping: fingers close around the object that a hand touches. Network frame, metres.

Each finger bends from a flat hand towards a fist, see body/hand_poses.py, until its skin touches the surface. A finger
that would close without touching anything keeps its pose.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .. import rotation, skeleton
from ..body import hand_poses
from ..body.hands import complete
from ..motion import Motion
from ..refine.hands.palm import SIDES, HandContact
from ..scene.geometry import areas, spread_over_surface

REACH = 0.25
"""Metres around the wrist within which triangles are sampled."""
SPACING = 0.003
"""Metres between samples of the surface."""
MOST_SAMPLES = 60_000
SKIN = 0.009
"""Metres from the bones of a finger to its skin."""
STEPS = 30
"""Poses between a flat hand and a fist that are tried."""
TIP = 0.8
"""Length of a finger's last bone over that of the one before."""
FINGERS, JOINTS = 5, 3
"""Of a hand, and of each finger."""


def grasp(motion: Motion, contact: HandContact, triangles: np.ndarray, frame: int) -> tuple[Motion, int]:
    """Return a motion whose fingers hold the object that a hand touches, and how many of the five fingers touch it.

    triangles: (F, 3, 3) of the object as it is in ``frame``, a frame in which the hand is on it. The fingers close as
    the contact's weight rises. The returned motion has all 55 joints.
    """
    whole = replace(motion, rotations=complete(motion.rotations))
    first = skeleton.INDEX[f"{contact.side}_index1"]
    own = slice(first, first + FINGERS * JOINTS)
    turns = _between_flat_and_fist(contact.side)
    touching = _touching(whole.pose_slice(slice(frame, frame + 1)), contact.side, own, turns, triangles)
    held = touching.any(axis=0)
    pose = whole.rotations[frame, own].reshape(FINGERS, JOINTS, 4).copy()
    for finger in np.flatnonzero(held):
        pose[finger] = turns[touching[:, finger].argmax(), finger]
    rotations = whole.rotations.copy()
    target = np.broadcast_to(pose.reshape(-1, 4), rotations[:, own].shape)
    rotations[:, own] = rotation.slerp(rotations[:, own], target, contact.weight[:, None])
    return replace(whole, rotations=rotations), int(held.sum())


def _between_flat_and_fist(side: str) -> np.ndarray:
    """Return local quaternions (STEPS, 5, 3, 4), w, x, y, z, of a hand that closes."""
    part = slice(SIDES.index(side) * FINGERS * JOINTS, (SIDES.index(side) + 1) * FINGERS * JOINTS)
    flat, fist = (
        rotation.to_axis_angle(hand_poses.rotations(hand_poses.code(kind))[part]) for kind in ("flat", "fist")
    )
    share = np.linspace(0, 1, STEPS)[:, None, None]
    return rotation.from_axis_angle(flat + share * (fist - flat)).reshape(STEPS, FINGERS, JOINTS, 4)


def _touching(pose: Motion, side: str, own: slice, turns: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return which fingers touch the surface in each pose of a closing hand (STEPS, 5).

    pose: one frame. own: the joints of the hand's fingers. turns: their local quaternions (STEPS, 5, 3, 4).
    triangles: (F, 3, 3) of the surface.
    """
    from scipy.spatial import cKDTree

    wrist = pose.forward_kinematics()[0][0, skeleton.INDEX[f"{side}_wrist"]]
    low, high = triangles.min(axis=1), triangles.max(axis=1)
    near = triangles[((low < wrist + REACH) & (high > wrist - REACH)).all(axis=1)]
    if not len(near):
        return np.zeros((STEPS, FINGERS), dtype=bool)
    count = int(np.clip(areas(near).sum() / SPACING**2, 1000, MOST_SAMPLES))
    surface = cKDTree(spread_over_surface(near, count)[0])
    rotations = np.repeat(pose.rotations, STEPS, axis=0)
    rotations[:, own] = turns.reshape(STEPS, -1, 4)
    closing = replace(
        pose, root=np.repeat(pose.root, STEPS, axis=0), rotations=rotations, contacts=None, actions=None
    )
    joints, globals_ = closing.forward_kinematics()
    heads = joints[:, own].reshape(STEPS, FINGERS, JOINTS, 3)
    rest = closing.rest_joints[own].reshape(FINGERS, JOINTS, 3)
    last = globals_[:, own].reshape(STEPS, FINGERS, JOINTS, 4)[:, :, -1]
    tips = heads[:, :, -1] + rotation.rotate(last, TIP * (rest[:, -1] - rest[:, -2]))
    bones = np.concatenate([heads, tips[:, :, None]], axis=2)
    along = np.linspace(0, 1, 5)[:, None]
    # Without the palm, which is on the object already.
    points = bones[:, :, :-1, None] + along * (bones[:, :, 1:, None] - bones[:, :, :-1, None])
    away = surface.query(points.reshape(-1, 3))[0].reshape(STEPS, FINGERS, -1)
    return away.min(axis=-1) < SKIN
