"""Turn the head of a take towards somebody or something. Network frame, metres, radians."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from .. import rotation, skeleton
from ..body.hands import complete
from ..body.joint_limits import limits
from ..easing import smoothstep
from ..motion import Motion

EASE = 0.5
"""Seconds in which the head turns to the target, and back."""

YAW, UP, DOWN = (np.radians(degrees) for degrees in (75.0, 45.0, 50.0))
"""Farthest that the head turns to a side, up and down, relative to the chest."""

TURN_BACK = np.radians((110.0, 160.0))
"""Angles to a side between which a target behind the body is given up."""

EYES = np.radians(25.0)
"""Farthest that the eyes turn in the head."""

NECK = 0.4
"""Share of the turn that is the neck's; the head's is the rest."""

SMOOTH = 0.12
"""Seconds over which the turn is smoothed: a target may jump."""

_CHEST, _NECK, _HEAD = (skeleton.INDEX[name] for name in ("spine3", "neck", "head"))
_LIMITS = limits()
_EYES = [skeleton.INDEX[f"{side}_eye_smplhf"] for side in ("left", "right")]


def look_at(
    motion: Motion, target: np.ndarray, first: int = 0, last: int | None = None, ease: float = EASE
) -> Motion:
    """Return a motion that looks at a target in some of its frames.

    target: (3,), or (T, 3) for one that moves. first, last: frames in which it looks; it turns there in the ``ease``
    seconds from ``first`` on and back in those before ``last``; left out, it looks at the target until the end. Neck
    and head turn as far as their joints allow, the eyes a little farther; all other joints and frames stay as they are.
    Raises ValueError for an empty range.
    """
    count = len(motion)
    end = count - 1 if last is None else min(last, count - 1)
    first = max(first, 0)
    if end < first:
        raise ValueError(f"frames {first} to {end} are empty")
    weight = _weights(count, first, end, ease * motion.fps, last is not None and last < count - 1)
    whole = complete(motion.rotations)
    globals_ = skeleton.forward_kinematics(motion.root, whole, motion.rest_joints)[1]
    aim, now = _angles(motion, whole, np.broadcast_to(target, (count, 3)))
    behind = smoothstep((TURN_BACK[1] - np.abs(aim[:, 0])) / (TURN_BACK[1] - TURN_BACK[0]))
    reach = np.stack([np.clip(aim[:, 0], -YAW, YAW), np.clip(aim[:, 1], -DOWN, UP)], axis=-1)
    sigma = SMOOTH * motion.fps
    reach = gaussian_filter1d(reach * behind[:, None], sigma, axis=0, mode="nearest")
    behind = gaussian_filter1d(behind, sigma, mode="nearest")
    change = (reach - behind[:, None] * now) * weight[:, None]
    turn = rotation.multiply(_direction(now + change), rotation.conjugate(_direction(now)))
    # From the chest's frame to the world's.
    chest = globals_[:, _CHEST]
    turn = rotation.multiply(rotation.multiply(chest, turn), rotation.conjugate(chest))
    still = np.broadcast_to(np.array([1.0, 0.0, 0.0, 0.0]), turn.shape)
    neck = rotation.multiply(rotation.slerp(still, turn, np.full(count, NECK)), globals_[:, _NECK])
    head = rotation.multiply(turn, globals_[:, _HEAD])
    made = whole.copy()
    made[:, _NECK] = _limited(rotation.multiply(rotation.conjugate(chest), neck), whole[:, _NECK], _NECK)
    neck = rotation.multiply(chest, made[:, _NECK])
    made[:, _HEAD] = _limited(rotation.multiply(rotation.conjugate(neck), head), whole[:, _HEAD], _HEAD)
    rest = np.clip((aim - now - change) * (weight * behind)[:, None], -EYES, EYES)
    for eye in _EYES:
        made[:, eye] = rotation.multiply(_direction(rest), whole[:, eye])
    used = weight > 0
    made = np.where(used[:, None, None], made, whole)
    return replace(motion, rotations=rotation.continuous(made))


def _weights(count: int, first: int, last: int, ease: float, back: bool) -> np.ndarray:
    """Return how much of the turn is made in each frame (T,)."""
    frame = np.arange(count)
    weight = smoothstep((frame - first) / max(ease, 1.0))
    if back:
        weight = weight * smoothstep((last - frame) / max(ease, 1.0))
    return np.where((frame >= first) & (frame <= last), weight, 0.0)


def _angles(motion: Motion, whole: np.ndarray, target: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return yaw and pitch (T, 2) of the target from between the eyes, and of the face, in the chest's frame."""
    joints, globals_ = skeleton.forward_kinematics(motion.root, whole, motion.rest_joints)
    eyes = joints[:, _EYES].mean(1)
    back = rotation.conjugate(globals_[:, _CHEST])
    face = rotation.rotate(globals_[:, _HEAD], np.array([0.0, 0.0, 1.0]))
    return _yaw_pitch(rotation.rotate(back, target - eyes)), _yaw_pitch(rotation.rotate(back, face))


def _yaw_pitch(directions: np.ndarray) -> np.ndarray:
    """Return yaw to the left and pitch upward (T, 2) of directions (T, 3)."""
    level = np.hypot(directions[:, 0], directions[:, 2])
    return np.stack(
        [np.arctan2(directions[:, 0], directions[:, 2]), np.arctan2(directions[:, 1], level)], axis=-1
    )


def _direction(angles: np.ndarray) -> np.ndarray:
    """Return the rotations (T, 4) that turn +Z to yaw and pitch (T, 2)."""
    side = np.zeros((len(angles), 3))
    side[:, 0] = -angles[:, 1]
    return rotation.multiply(rotation.about_y(angles[:, 0]), rotation.from_axis_angle(side))


def _limited(turned: np.ndarray, before: np.ndarray, joint: int) -> np.ndarray:
    """Return rotations (T, 4) of a joint within its limit, or as far from the zero pose as they were before."""
    allowed = np.maximum(_LIMITS[joint], np.linalg.norm(rotation.to_axis_angle(before), axis=-1))
    vector = rotation.to_axis_angle(turned)
    angle = np.linalg.norm(vector, axis=-1)
    share = np.minimum(1.0, allowed / np.maximum(angle, 1e-9))
    return rotation.from_axis_angle(vector * share[:, None])
