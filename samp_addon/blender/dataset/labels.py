"""Joints, contacts and labels of each frame of a take, as arrays in Blender's world. Needs no Blender itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ... import frames, skeleton
from ...body import human
from ...body.hands import complete
from ...body.human import Human
from ...motion import Motion
from ...scene.distance.surface_samples import samples_in_box
from ...scene.geometry import SceneGeometry
from ...vocabulary import ACTIONS, CONTACTS

PHASES = ("move", "interact", "rest")
"""On the way; sitting or lying down; at the final place."""

SPACING = 0.02
"""Metres between the samples of the scene's surface."""

TOUCH = 0.025
"""Metres from skin to the nearest sample of a surface that it touches: 2 cm, and as far aside as samples lie."""

AT_REST = 0.05
"""Metres around its final place in which the pelvis is at rest."""

NOTHING = -1
"""In place of an object's index."""

_HAND = tuple(f"{finger}{k}" for finger in ("index", "middle", "pinky", "ring", "thumb") for k in (1, 2, 3))
_PARTS = {"pelvis": ("pelvis", "left_hip", "right_hip")} | {
    f"{side}_{part}": tuple(f"{side}_{name}" for name in names)
    for side in ("right", "left")
    for part, names in (("hand", ("wrist", *_HAND)), ("foot", ("ankle", "foot")))
}
"""Joints whose skin counts to a contact."""


@dataclass(frozen=True)
class _Touching:
    """For each frame and part of CONTACTS: gap (T, 5) to the nearest surface, metres, and its object (T, 5)."""

    gap: np.ndarray
    object: np.ndarray


def arrays(motion: Motion, geometry: SceneGeometry, body: Human) -> dict[str, np.ndarray]:
    """Return the arrays of a take, by name.

    fps (), frames per second. joints (T, 55, 3), metres, of joint_names (55,). facing (T, 3), horizontal and of length
    1. contacts (T, 5) from 0 to 1 as the network predicts them, of contact_names (5,), and actions (T, 5), weights of
    action_names (5,); both only where the method knows them. contact_objects (T, 5): the object that the skin of the
    part touches, by its index in object_names, or -1. support (T,): the object that carries the body, that of the
    pelvis before that of the nearer foot, or -1. phase (T,): index in phase_names (3,).
    """
    joints, _ = skeleton.forward_kinematics(motion.root, complete(motion.rotations), body.joints)
    touching = _touching(motion, geometry, body)
    objects = np.where(touching.gap <= TOUCH, touching.object, NOTHING).astype(np.int32)
    found = {
        "fps": np.array(float(motion.fps)),
        "joints": frames.to_blender(joints).astype(np.float32),
        "joint_names": np.array(skeleton.JOINTS),
        "facing": frames.to_blender(motion.headings()).astype(np.float32),
        "contact_names": np.array(CONTACTS),
        "contact_objects": objects,
        "support": _support(objects, touching.gap),
        "object_names": np.array(geometry.names, dtype=str),
        "phase": phases(motion),
        "phase_names": np.array(PHASES),
        "action_names": np.array(ACTIONS),
    }
    own = {"contacts": motion.contacts, "actions": motion.actions}
    return found | {name: value.astype(np.float32) for name, value in own.items() if value is not None}


def phases(motion: Motion) -> np.ndarray:
    """Return the phase (T,) of each frame, an index into PHASES."""
    away = np.linalg.norm(motion.root - motion.root[-1], axis=-1) > AT_REST
    rest = int(np.flatnonzero(away)[-1]) + 1 if away.any() else 0
    begun = rest if motion.interaction_start is None else min(motion.interaction_start, rest)
    at = np.arange(len(motion))
    return ((at >= begun).astype(np.int8) + (at >= rest)).astype(np.int8)


def _support(objects: np.ndarray, gap: np.ndarray) -> np.ndarray:
    """Return what carries the body (T,). objects, gap: (T, 5), of CONTACTS."""
    pelvis, feet = CONTACTS.index("pelvis"), [CONTACTS.index(f"{side}_foot") for side in ("right", "left")]
    nearer = np.take_along_axis(objects[:, feet], gap[:, feet].argmin(1)[:, None], 1)[:, 0]
    return np.where(objects[:, pelvis] != NOTHING, objects[:, pelvis], nearer).astype(np.int32)


def _touching(motion: Motion, geometry: SceneGeometry, body: Human) -> _Touching:
    subset = body.collision
    skin = human.skin(body, motion, subset)
    low, high = skin.min((0, 1)).astype(float) - 2 * TOUCH, skin.max((0, 1)).astype(float) + 2 * TOUCH
    samples, triangles = samples_in_box(geometry.triangles, low, high, SPACING)
    gap = np.full((len(motion), len(CONTACTS)), np.inf)
    touched = np.full(gap.shape, NOTHING)
    if not len(samples):
        return _Touching(gap, touched)
    tree, owners = cKDTree(samples), geometry.object_ids[triangles]
    joint = np.take_along_axis(body.weight_joints, body.weights.argmax(1)[:, None], 1)[subset, 0]
    for column, part in enumerate(CONTACTS):
        own = np.flatnonzero(np.isin(joint, [skeleton.INDEX[name] for name in _PARTS[part]]))
        distance, nearest = tree.query(skin[:, own].astype(np.float64), distance_upper_bound=TOUCH)
        best = distance.argmin(1)[:, None]
        gap[:, column] = np.take_along_axis(distance, best, 1)[:, 0]
        hit = np.take_along_axis(nearest, best, 1)[:, 0]
        touched[:, column] = np.where(hit < len(owners), owners[np.minimum(hit, len(owners) - 1)], NOTHING)
    return _Touching(gap, touched)
