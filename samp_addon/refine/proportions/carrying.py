"""A take carried to a body of other proportions: same rotations, other hips, feet where they stood.

Network frame, metres.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ... import rotation
from ...body import human
from ...body.human import Human
from ...body.proportions import leg_length
from ...easing import smoothstep
from ...motion import Motion
from ...vocabulary import CONTACTS
from ..feet.foot import BALL_HEIGHT, FEET, HEEL_BACK, Foot
from ..feet.foot_lock import lock_to_plans
from ..feet.plan import FootPlan, plan_feet
from ..inverse_kinematics import solve_limb
from ..runs import runs
from . import heels
from .footprints import Footprints
from .hips import hips, seat_depth

SEAT = 0.1  # height of the hips over their seat, in lengths of a leg, for rigs without skin
FOLLOW = 0.35  # seconds over which a foot blends between its planned place and its leg
SWING = 1.5  # seconds between two stances of a foot up to which they are one step
# Without contact labels, hips that are so low (lengths of a leg) and slow (m/s) for so long (seconds) rest.
LOW, STILL, LONG = 0.75, 0.12, 0.5
SAME = 1e-4  # metres between joints of the same proportions


@dataclass(frozen=True, eq=False)
class Build:
    """The proportions of a body.

    joints: (55, 3) in the T-pose, the pelvis at the origin, the balls of the feet BALL_HEIGHT over the soles. seat:
    from the hips back to the skin, or None without skin.
    """

    joints: np.ndarray
    seat: float | None

    @classmethod
    def over_soles(cls, joints: np.ndarray, sole: float, seat: float | None) -> Build:
        """Return a build with the balls of the feet put over the soles: the foot lock assumes that they are there.

        sole: from the ankle joint down to the sole.
        """
        joints = joints.copy()
        for foot in FEET:
            joints[foot.ball, 1] = joints[foot.ankle, 1] - sole + BALL_HEIGHT
        return cls(joints, seat)

    @classmethod
    def of(cls, body: Human) -> Build:
        """Return the build of a body with skin."""
        ankle = float(np.mean([body.joints[foot.ankle, 1] for foot in FEET]))
        return cls.over_soles(body.joints, ankle - body.floor, seat_depth(body.vertices, body.joints))


@dataclass(frozen=True, eq=False)
class Carried:
    """A take on another build.

    motion: with the build's rest joints. planned: (T, 2, 3) places of the ankles, right one first, in the frames of
    stands: (T, 2) flags.
    """

    motion: Motion
    planned: np.ndarray
    stands: np.ndarray


def carry(motion: Motion, build: Build, seat: float | None = None, knees: bool = False) -> Carried:
    """Return a take on another build.

    seat: from the hips of the take's own body back to its skin, if known. knees: whether the knees of a body that rests
    stay where they are over the seat: hips move forward where thighs are shorter, and where the body is thicker, and
    heels rise where shins are shorter.
    """
    prints = Footprints.of(motion)
    plans = plan_feet(motion, prints)
    root = _root(motion, build, prints, seat)
    if knees:
        rests = _rests(motion, prints)
        root = root + rests[:, None] * _forward(motion, build, seat)
    body = replace(motion, root=root, rest_joints=build.joints)
    body = _follow_feet(body, motion, plans)
    planned = plan_feet(body, prints, known=plans)
    if knees:
        planned = heels.raised(planned, body, motion, rests)
    return Carried(
        lock_to_plans(body, planned, prints),
        np.stack([plan.ankle for plan in planned], axis=1),
        np.stack([plan.standing for plan in planned], axis=1),
    )


def for_body(motion: Motion, body: Human) -> Motion:
    """Return a take for a body: as it is where its proportions are the body's, else carried to it."""
    joints = motion.rest_joints
    count = min(len(joints), len(body.joints))
    if np.abs(joints[:count] - body.joints[:count]).max() < SAME:
        return motion
    own = human.load()
    if np.abs(joints[:count] - own.joints[:count]).max() >= SAME:
        own = own.with_joints(joints)
    made = carry(motion, Build.of(body), seat_depth(own.vertices, own.joints), knees=True).motion
    return replace(made, rest_joints=body.joints)


def sole_height(joints: np.ndarray) -> float:
    """Return the height of the soles of joints (55, 3) in the T-pose."""
    return float(np.mean([joints[foot.ball, 1] for foot in FEET])) - BALL_HEIGHT


def _root(motion: Motion, build: Build, prints: Footprints, seat: float | None) -> np.ndarray:
    """Return the pelvis positions (T, 3) of the build, its hips over the same place of the floor as the take's.

    Their height is that of the legs while the body stands, that of the body over the seat while it rests, and
    interpolated between the two. seat: see carry.
    """
    source, target = motion.rest_joints, build.joints
    positions, globals_ = motion.forward_kinematics()
    middle = hips(positions)
    ground = prints.height(len(motion))
    over = middle[:, 1] - ground
    tall, taller = _standing_height(source), _standing_height(target)
    standing = over * (taller / tall - 1)
    if seat is None or build.seat is None:
        seated = SEAT * (leg_length(target) - leg_length(source))
    else:
        seated = build.seat - seat
    middle[:, 1] += hip_lift(over, _resting(motion, over / tall), standing, seated, tall)
    return middle - rotation.rotate(globals_[:, 0], np.broadcast_to(hips(target), middle.shape))


def _forward(motion: Motion, build: Build, seat: float | None) -> np.ndarray:
    """Return by how much hips that rest move forward (T, 3), metres: as much as thighs are shorter and backs thicker.

    seat: see carry.
    """
    lengths = [
        np.mean([np.linalg.norm(joints[foot.knee] - joints[foot.hip]) for foot in FEET])
        for joints in (motion.rest_joints, build.joints)
    ]
    positions, _ = motion.forward_kinematics()
    middle = hips(positions)
    thighs = (positions[:, [foot.knee for foot in FEET]].mean(1) - middle) * [1.0, 0.0, 1.0]
    thicker = 0.0 if seat is None or build.seat is None else max(build.seat - seat, 0.0)
    ahead = thighs / np.maximum(np.linalg.norm(thighs, axis=-1, keepdims=True), 0.1)
    return max(1 - lengths[1] / lengths[0], 0.0) * thighs + thicker * ahead


def _rests(motion: Motion, prints: Footprints) -> np.ndarray:
    """Return the share (T,) with which a body rests: 1 on its seat, 0 while it stands, by the height of its hips."""
    over = hips(motion.forward_kinematics()[0])[:, 1] - prints.height(len(motion))
    tall = _standing_height(motion.rest_joints)
    return 1 - hip_lift(over, _resting(motion, over / tall), np.ones(len(motion)), 0.0, tall)


def _standing_height(joints: np.ndarray) -> float:
    """Return the height of the hips over the soles of joints (55, 3) in the T-pose."""
    return float(hips(joints)[1] - sole_height(joints))


def _resting(motion: Motion, over: np.ndarray) -> np.ndarray:
    """Return flags (T,) of the frames in which the pelvis rests. over: (T,) height of the hips, in lengths of a leg."""
    if motion.contacts is not None:
        return motion.contacts[:, CONTACTS.index("pelvis")] > 0.5
    if len(motion) < 2:
        return over < LOW
    speed = np.linalg.norm(np.gradient(motion.root, 1 / motion.fps, axis=0), axis=-1)
    still = (over < LOW) & (speed < STILL)
    return gaussian_filter1d(still.astype(float), LONG / 2 * motion.fps, mode="nearest") > 0.5


def hip_lift(
    over: np.ndarray, resting: np.ndarray, standing: np.ndarray, seated: float, tall: float
) -> np.ndarray:
    """Return the metres (T,) by which the hips are raised.

    over: (T,) their height over the ground. resting: (T,) flags. seated: lift while resting. standing: (T,) lift at
    the usual height of walking, at most ``tall``. In between the lift is interpolated by height.
    """
    rests = runs(resting, 1, 0)
    if not rests:
        return standing
    # The lower level is that of the rest which is nearest in time.
    count = np.arange(len(over))
    away = [np.maximum(np.maximum(first - count, count - last + 1), 0) for first, last in rests]
    levels = np.array([np.median(over[first:last]) for first, last in rests])
    seat = levels[np.argmin(away, axis=0)]
    # Standing legs are not fully stretched.
    stands = np.clip(np.percentile(over[~resting], 80), 0.75 * tall, tall) if not resting.all() else tall
    share = np.clip((over - seat) / np.maximum(stands - seat, 0.1), 0.0, 1.0)
    return seated + share * (standing - seated)


def _follow_feet(body: Motion, motion: Motion, plans: list[FootPlan]) -> Motion:
    """Move the feet of the build's motion to those of the take while they stand or step.

    The middles of the soles coincide. Feet that hang or lie follow their legs.
    """
    source, orientations = motion.forward_kinematics()
    own, _ = body.forward_kinematics()
    rotations = body.rotations
    for plan in plans:
        foot = plan.foot
        shift = sole_middle(motion.rest_joints, foot) - sole_middle(body.rest_joints, foot)
        place = source[:, foot.ankle] + rotation.rotate(
            orientations[:, foot.ankle], np.broadcast_to(shift, source[:, foot.ankle].shape)
        )
        share = _step_weight(plan, len(motion), motion.fps)[:, None]
        target = share * place + (1 - share) * own[:, foot.ankle]
        rotations = solve_limb(body.root, rotations, body.rest_joints, f"{foot.side}_leg", target)
    return replace(body, rotations=rotations)


def sole_middle(joints: np.ndarray, foot: Foot) -> np.ndarray:
    """Return the middle (3,) of a sole relative to its ankle joint, in the T-pose. joints: (55, 3)."""
    ankle, ball = joints[foot.ankle], joints[foot.ball]
    forward = (ball - ankle) * [1.0, 0.0, 1.0]
    back = HEEL_BACK * forward / np.linalg.norm(forward)
    middle = (ball - ankle - back) / 2
    middle[1] = ball[1] - BALL_HEIGHT - ankle[1]
    return middle


def _step_weight(plan: FootPlan, count: int, fps: float) -> np.ndarray:
    """Return weights (count,), 1 while a foot stands or steps from one stance to the next, fading to 0 around."""
    steps = plan.standing.astype(float)
    for one, other in zip(plan.stances[:-1], plan.stances[1:], strict=True):
        if other.first - one.last <= SWING * fps:
            steps[one.last : other.first] = 1.0
    inside = np.flatnonzero(steps)
    if not len(inside):
        return steps
    after = np.clip(np.searchsorted(inside, np.arange(count)), 0, len(inside) - 1)
    before = np.clip(after - 1, 0, None)
    away = np.minimum(np.abs(inside[after] - np.arange(count)), np.abs(inside[before] - np.arange(count)))
    return smoothstep(1 - away / (FOLLOW * fps))
