"""Windows joined to one take (section 3.4): no jump at the seams, contacts, locked feet. Network frame, metres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ... import rotation
from ...motion import Motion, velocities
from ...refine.feet.foot import FEET
from ...refine.feet.foot_lock import FOUND, lock_feet
from ...refine.feet.found_contacts import LOW, foot_contacts
from ...refine.feet.grounding import grounded, sole_heights
from ...vocabulary import ACTIONS, CONTACTS, SEATED
from .resting import backwards

MATCHED = 18
"""Frames on each side of a seam over which the velocities of both windows are blended to a common one."""
SEAM = 4.0
"""Frames around a seam in which the motion is smoothed; sigma of the weight."""
SMOOTHING = 1.0
"""Frames: sigma of the Gaussian at a seam."""
WALKING = 0.25
"""Metres per second of the pelvis above which somebody walks."""


@dataclass(frozen=True)
class Part:
    """A window: its motion, and what the body does at its begin and at its end."""

    motion: Motion
    begin: str
    end: str


def joined(parts: Sequence[Part]) -> tuple[Motion, list[int]]:
    """Return one motion of windows in a row, and the frames at which each of them ends.

    A window begins with the frame with which the one before it ends, which is kept once, and goes on with its velocity:
    both windows are led to the mean of the two velocities.
    """
    parts = _matched(parts)
    root, quats = [parts[0].motion.root[:1]], [parts[0].motion.rotations[:1]]
    ends, weights = [0], [_actions(parts[0])[:1]]
    for part in parts:
        root.append(part.motion.root[1:])
        quats.append(part.motion.rotations[1:])
        weights.append(_actions(part)[1:])
        ends.append(ends[-1] + len(part.motion) - 1)
    motion = replace(
        parts[0].motion,
        root=np.concatenate(root),
        rotations=rotation.continuous(np.concatenate(quats)),
        actions=np.concatenate(weights),
    )
    return _even(motion, ends[1:-1]), ends[1:]


def finished(motion: Motion, floor: np.ndarray, under: np.ndarray) -> Motion:
    """Return the motion with contacts, on the floor, and with feet that stay where they stand.

    floor: heights (T,) under the pelvis. under: heights (T, 2) under the feet, in the order of FEET. The feet of a body
    that sits down or rises stay on the floor as well: its legs bend, while the pelvis keeps to its route.
    """
    resting = _resting(motion)
    motion = grounded(motion, floor, resting)
    motion = replace(motion, contacts=contacts(motion, floor))
    under = _even_stances(under, motion.contacts)
    return lock_feet(motion, under, FOUND, np.clip(1 - 2 * resting, 0, 1))


def _even_stances(under: np.ndarray, contacts_: np.ndarray) -> np.ndarray:
    """Return heights (T, 2) under the feet, one for each stance: a foot that slides does not pass an edge."""
    made = under.copy()
    for column, foot in enumerate(FEET):
        stands = contacts_[:, foot.column] > 0.5
        for run in np.split(np.arange(len(under)), np.flatnonzero(np.diff(stands)) + 1):
            if stands[run[0]]:
                made[run, column] = np.median(under[run, column])
    return made


def contacts(motion: Motion, floor: np.ndarray) -> np.ndarray:
    """Return the contacts (T, 5) by speed and height of the feet, and of the pelvis by the action.

    Speed and height are those over the floor (T,): feet that stand on something stay there while the body steps down.
    """
    found, rests = np.zeros((len(motion), len(CONTACTS))), _resting(motion) > 0.5
    found[:, CONTACTS.index("pelvis")] = rests
    high = sole_heights(motion) - floor[:, None] > LOW
    level = replace(motion, root=motion.root - floor[:, None] * np.array([0.0, 1.0, 0.0]))
    found[:, [foot.column for foot in FEET]] = foot_contacts(level) * ~(rests[:, None] & high)
    return found


def _resting(motion: Motion) -> np.ndarray:
    """Return the weight (T,) of the actions in which the body rests on something."""
    return motion.actions[:, [ACTIONS.index(name) for name in SEATED]].sum(1)


def interaction_start(motion: Motion) -> int | None:
    """Return the first frame of the last run in which the body rests on something, or None."""
    busy = _resting(motion) > 0.5
    if not busy[-1]:
        return None
    idle = np.flatnonzero(~busy)
    return int(idle[-1] + 1) if len(idle) else 0


def _actions(part: Part) -> np.ndarray:
    """Return the weights (T, 5) of the actions in a window: walking by speed, resting by the pelvis' height."""
    motion = part.motion
    weights = np.zeros((len(motion), len(ACTIONS)))
    height = motion.root[:, 1]
    for name, end, other in ((part.begin, 0, -1), (part.end, -1, 0)):
        if name in SEATED:
            drop = height[other] - height[end]
            still = part.begin in SEATED and part.end in SEATED
            share = np.ones(len(motion)) if still or abs(drop) < 0.05 else (height[other] - height) / drop
            weights[:, ACTIONS.index(name)] = np.maximum(
                weights[:, ACTIONS.index(name)], np.clip(share * 1.25 - 0.25, 0, 1)
            )
    left = 1 - np.clip(weights.sum(1), 0, 1)
    speed = np.linalg.norm(velocities(motion.root, motion.fps)[:, [0, 2]], axis=-1)
    walks = np.clip(gaussian_filter1d(speed, 3.0, mode="nearest") / WALKING - 0.5, 0, 1)
    weights[:, ACTIONS.index("walk")], weights[:, ACTIONS.index("idle")] = left * walks, left * (1 - walks)
    return weights / np.maximum(weights.sum(1, keepdims=True), 1e-9)


def _matched(parts: Sequence[Part]) -> list[Part]:
    """Return windows each of which begins with the velocities with which the one before it ends."""
    made = list(parts)
    for k in range(len(parts) - 1):
        before, after = made[k].motion, made[k + 1].motion
        least = min(len(before), len(after)) - 1
        if least < 2:
            continue
        back, ahead = backwards(before), after
        jump = _velocities(ahead)[0] + _velocities(back)[0], _velocities(ahead)[1] + _velocities(back)[1]
        count = min(MATCHED, least)
        made[k] = replace(made[k], motion=backwards(_led(back, jump, count)))
        made[k + 1] = replace(made[k + 1], motion=_led(ahead, jump, count))
    return made


def _velocities(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Return the velocity (3,) and the angular velocities (J, 3) of the first frame, per frame, of second order."""
    root, quats = motion.root, motion.rotations
    first = rotation.conjugate(quats[0])
    turns = [rotation.to_axis_angle(rotation.multiply(first, quats[k])) for k in (1, 2)]
    return 2 * (root[1] - root[0]) - (root[2] - root[0]) / 2, 2 * turns[0] - turns[1] / 2


def _led(motion: Motion, jump: tuple[np.ndarray, np.ndarray], count: int) -> Motion:
    """Return a motion whose first velocities differ by half a jump of its own; it stays as it is from `count` on."""
    frames = np.arange(len(motion))
    course = -0.5 * frames * np.clip(1 - frames / count, 0, 1) ** 3
    turns = rotation.from_axis_angle(course[:, None, None] * jump[1])
    return replace(
        motion,
        root=motion.root + course[:, None] * jump[0],
        rotations=rotation.multiply(motion.rotations, turns),
    )


def _even(motion: Motion, seams: Sequence[int]) -> Motion:
    """Return the motion smoothed around the seams; elsewhere it stays as it is."""
    if not seams:
        return motion
    frames = np.arange(len(motion))
    share = np.max([np.exp(-0.5 * ((frames - seam) / SEAM) ** 2) for seam in seams], axis=0)
    soft = motion.smoothed(SMOOTHING)
    return replace(
        motion,
        root=motion.root + share[:, None] * (soft.root - motion.root),
        rotations=rotation.slerp(motion.rotations, soft.rotations, share[:, None]),
    )
