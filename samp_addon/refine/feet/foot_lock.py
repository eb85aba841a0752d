"""The foot lock: a foot that bears weight stays where it is, clears the ground on its way to the next stance, and does
not sink into it. Network frame, metres.

One mechanism with two sources of stances. ``lock_feet`` serves raw rollouts and captured motion, which have contact
labels and a floor of known height: balls are pinned. ``lock_to_plans`` serves refinement and retargeting, which have
only joints and a ground to query: whole soles are pinned (plan.py). ``Settings`` holds the constants that differ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import distance_transform_edt, gaussian_filter1d

from ... import rotation, skeleton
from ...easing import anticipate, smoothstep
from ...frames import direction_yaw
from ...motion import Motion
from ..field import Ground
from . import stances
from .corrections import RISE, Correction, apply, carried_on, spread, swing_clearance
from .foot import FEET, Foot, sole_offsets, sole_points, toe_tips
from .plan import OVER, FootPlan
from .steps import stepping

UNBENT_TOE_AHEAD = (
    0.07  # metres from the ball of the sole to the tip of the toes, a little more than TOE_AHEAD:
)
# while a foot is lifted, how far its toes will bend is not known yet.
SEATED_PELVIS, UPRIGHT_PELVIS = 0.7, 0.9  # heights of the pelvis over the ankles, in lengths of a leg
NO_GROUND = -1e3  # height of the ground where there is none


@dataclass(frozen=True)
class Settings:
    """Constants of a foot lock. clearance: metres between the sole of a swinging foot and the ground. blend: frames at
    30 fps over which corrections fade. slack: metres over or under the floor at which a standing foot is left. fastest:
    m/s of a foot that may stand. carries: whether a foot that swings while the other one does not stand may carry the
    body, and so is not lifted. steps: whether a body that glides on both feet makes steps instead."""

    clearance: float
    blend: float
    slack: float = 0.0
    fastest: float = stances.SWING_SPEED
    carries: bool = False
    steps: bool = False


# A network that is unsure of its phase drags its feet: its locks are farther from where the feet were.
LABELLED = Settings(clearance=0.036, blend=7, steps=True)
# Refinement changes motion that is mostly sound, and keeps it close to its input.
PLANNED = Settings(clearance=0.03, blend=6)
# Captured feet swing soundly, and 3 mm in height are 5 degrees in a nearly straight knee.
CAPTURED = Settings(clearance=0.008, blend=7, slack=0.01)

# Contacts found by found_contacts.py: one foot stands at any time, however much the generated feet slide.
FOUND = Settings(clearance=0.036, blend=7, fastest=0.9, carries=True)

LIFT_SIGMA = 1.5  # frames at 30 fps of the Gaussian over the lift of a labelled swing
LIFT_FADES = 0.01  # metres of clearance below which that lift fades out
HELD_TURN, MOST_TURN = np.radians(15), np.radians(35)
"""Radians up to which the lock turns a standing foot in full, to keep its facing, and by which it turns it at most:
beyond, the foot pivots on its ball. Captured feet turn by 46 degrees against their shins at most (99.9 % of frames)."""
OFFSET_SIGMA = 0.75  # frames at 30 fps of the Gaussian over planned corrections


def lock_feet(
    motion: Motion,
    floor: np.ndarray | float = 0.0,
    settings: Settings = LABELLED,
    upright: np.ndarray | float = 1.0,
) -> Motion:
    """Pin the feet of a motion during the stances of its contact labels.

    floor: height of the support under the character, one number or (T,), or under each foot, (T, 2) in the order of
    FEET. settings: LABELLED, CAPTURED or FOUND. Where a pinned foot is out of the leg's reach the pelvis sinks a
    little, smoothly. upright: share of this sinking that is applied, one number or (T,); 0 for a body that rests.
    Raises ValueError without motion.contacts.
    """
    if motion.contacts is None:
        raise ValueError("foot lock needs the motion's contacts")
    floor = np.asarray(floor, dtype=np.float64)
    floors = np.broadcast_to(floor if floor.ndim == 2 else floor.reshape(-1, 1), (len(motion), len(FEET)))
    positions, _ = motion.forward_kinematics()
    found = [
        stances.from_contacts(
            positions[:, foot.ball], motion.contacts[:, foot.column] > 0.5, motion.fps, settings.fastest
        )
        for foot in FEET
    ]
    if settings.steps:
        found = stepping(motion, found)
    corrections = [
        _labelled(motion, foot, own, other, under, settings)
        for foot, own, other, under in zip(FEET, found, reversed(found), floors.T, strict=True)
    ]
    return apply(motion, corrections, lambda tips: floors.min(1), upright, eased=True)


def lock_to_plans(motion: Motion, plans: Sequence[FootPlan], ground: Ground) -> Motion:
    """Move the feet of a motion to their plans, right one first; corrections fade through the swings between."""
    positions, globals_ = motion.forward_kinematics()
    corrections = [
        _planned(motion, plan, other, positions[:, plan.foot.ankle], globals_[:, plan.foot.ankle], ground)
        for plan, other in zip(plans, reversed(plans), strict=True)
    ]
    # Seated and lying bodies do not sink because a foot is out of reach.
    height = _pelvis_over_ankles(positions)
    upright = smoothstep((height - SEATED_PELVIS) / (UPRIGHT_PELVIS - SEATED_PELVIS))
    under_toes = lambda tips: np.nan_to_num(ground.support(tips)[0], nan=NO_GROUND) + OVER
    return apply(motion, corrections, under_toes, upright)


def _labelled(
    motion: Motion,
    foot: Foot,
    found: list[stances.Stance],
    others: list[stances.Stance],
    floor: np.ndarray,
    settings: Settings,
) -> Correction:
    """Return the correction that pins the ball of a foot at its mean place during each labelled stance.

    found, others: stances of the foot and of the other one.
    """
    positions, globals_ = motion.forward_kinematics()
    ball_joint = positions[:, foot.ball]
    heel, ball = sole_points(positions, globals_, motion.rest_joints, foot.side)
    blend = max(2, round(settings.blend * motion.fps / 30))
    offset = np.zeros((len(motion), 3))
    lowest = np.minimum(heel[:, 1], ball[:, 1]) - floor
    standing = stances.standing(found, len(motion))
    for stance in found:
        part = slice(stance.first, stance.last)
        offset[part] = ball_joint[part].mean(0) - ball_joint[part]
        offset[part, 1] = np.clip(lowest[part], -settings.slack, settings.slack) - lowest[part]
    offset = spread(offset, found, blend)
    offset += carried_on(offset, found, blend) * [1.0, 0.0, 1.0]
    toes = toe_tips(positions, globals_, motion.rest_joints, foot.side)[:, 1] - floor
    wanted = swing_clearance(ball_joint + offset, found, motion.fps, settings.clearance)
    if settings.carries:
        wanted = wanted * stances.standing(others, len(motion))
    lift = np.maximum(wanted - np.minimum(lowest, toes) - offset[:, 1], 0.0)
    # The smoothed lift is faded out: it would reach into the stances.
    lift = gaussian_filter1d(lift, LIFT_SIGMA * motion.fps / 30, mode="nearest")
    lift = lift * np.minimum(wanted / LIFT_FADES, 1.0)
    offset[:, 1] = np.where(standing, offset[:, 1], np.maximum(offset[:, 1] + lift, -lowest))
    turn = rotation.about_y(_held_facing(positions, foot, found, blend))
    back = positions[:, foot.ankle] - ball_joint  # the foot turns about its ball
    offset += rotation.rotate(turn, back) - back
    return Correction(foot, offset, standing, rotation.multiply(turn, globals_[:, foot.ankle]))


def _held_facing(
    positions: np.ndarray, foot: Foot, found: Sequence[stances.Stance], blend: int
) -> np.ndarray:
    """Return the turns (T,), radians about the vertical, that hold the facing of a foot during its stances.

    A body that turns on the spot would drag its heels around the balls of its feet. positions: (T, J, 3).
    """
    facing = np.unwrap(direction_yaw(positions[:, foot.ball] - positions[:, foot.ankle]))
    turn = np.zeros((len(facing), 1))
    for stance in found:
        own = facing[stance.first : stance.last]
        turn[stance.first : stance.last, 0] = _limited(own.mean() - own)
    turn = spread(turn, found, blend)
    return (turn + carried_on(turn, found, blend))[:, 0]


def _limited(turn: np.ndarray) -> np.ndarray:
    """Return turns (T,), radians, that stay below MOST_TURN, smoothly."""
    over = np.maximum(np.abs(turn) - HELD_TURN, 0.0)
    room = MOST_TURN - HELD_TURN
    return np.sign(turn) * (np.minimum(np.abs(turn), HELD_TURN) + room * np.tanh(over / room))


def _planned(
    motion: Motion, plan: FootPlan, other: FootPlan, ankle: np.ndarray, globals_: np.ndarray, ground: Ground
) -> Correction:
    """Return the correction that brings an ankle (T, 3), with global quaternions (T, 4), to its plan.

    other: the plan of the other foot.
    """
    blend = max(2, round(PLANNED.blend * motion.fps / 30))
    offset = np.where(plan.standing[:, None], plan.ankle - ankle, 0.0)
    turn = rotation.multiply(plan.orientation, rotation.conjugate(globals_))
    turn = np.where(plan.standing[:, None], rotation.to_axis_angle(rotation.continuous(turn)), 0.0)
    offset, turn = (
        gaussian_filter1d(
            spread(values, plan.stances, blend), OFFSET_SIGMA * motion.fps / 30, axis=0, mode="nearest"
        )
        for values in (offset, turn)
    )
    orientation = rotation.multiply(rotation.from_axis_angle(turn), globals_)
    offset[:, 1] += _lift(motion, plan, other, ankle + offset, orientation, ground)
    return Correction(plan.foot, offset, plan.standing, orientation)


def _lift(
    motion: Motion,
    plan: FootPlan,
    other: FootPlan,
    ankle: np.ndarray,
    orientation: np.ndarray,
    ground: Ground,
) -> np.ndarray:
    """Return the lift (T,) that keeps the sole of a swinging foot out of the ground, and clear of it while the other
    foot stands; a foot that swings while the other does not stand may itself carry the body."""
    need = np.zeros(len(ankle))
    heel, ball = sole_offsets(motion.rest_joints, plan.foot.side)
    wanted = swing_clearance(ankle, plan.stances, motion.fps, PLANNED.clearance)
    clear = np.where(other.standing, wanted, 0.0) + OVER
    toe = ball + UNBENT_TOE_AHEAD * (ball - heel) / np.linalg.norm(ball - heel)
    for point in (heel, ball, toe):
        end = ankle + rotation.rotate(orientation, np.broadcast_to(point, ankle.shape))
        height, _ = ground.support(end)
        need = np.maximum(need, np.nan_to_num(height + clear - end[:, 1], nan=0.0))
    # Right after a stance a foot rises no faster than a swing does.
    need *= smoothstep(distance_transform_edt(~plan.standing) / (RISE * motion.fps / 30))
    lift = anticipate(need, 3, 2.0 * motion.fps / 30)
    lift[plan.standing] = 0.0
    return lift


def _pelvis_over_ankles(positions: np.ndarray) -> np.ndarray:
    """Return the height (T,) of the pelvis over the lower ankle, in lengths of a leg. positions: (T, J, 3)."""
    ankles = [skeleton.INDEX[f"{side}_ankle"] for side in ("left", "right")]
    over = positions[:, 0, 1] - positions[:, ankles, 1].min(1)
    legs = np.linalg.norm(np.diff(positions[0][[1, 4, 7]], axis=0), axis=-1).sum()
    return over / legs
