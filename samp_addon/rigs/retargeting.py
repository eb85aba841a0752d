"""Retargeting of a take to a rig: same rotations, the pelvis at the height of the rig's legs, feet where they stood.

In the T-pose a rig is an SMPL-X body of other proportions (fitting.py). So a take for it is a Motion, and the foot lock
applies to its feet. Network frame, metres.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from .. import frames, rotation, skeleton
from ..body.hands import complete
from ..body.proportions import leg_length
from ..easing import smoothstep
from ..motion import Motion
from ..refine.feet.foot import BALL_HEIGHT, FEET, HEEL_BACK, Foot
from ..refine.feet.foot_lock import lock_to_plans
from ..refine.feet.plan import FootPlan, plan_feet
from ..refine.inverse_kinematics import solve_limb
from ..refine.runs import runs
from ..vocabulary import CONTACTS
from .fitting import Fit, fit
from .footprints import Footprints
from .landmarks import hips, seat_depth
from .rig import Rig

SEAT = 0.1  # height of the hips over their seat, in lengths of a leg, for rigs without skin
FOLLOW = 0.35  # seconds over which a foot blends between its planned place and its leg
SWING = 1.5  # seconds between two stances of a foot up to which they are one step
# Without contact labels, hips that are so low (lengths of a leg) and slow (m/s) for so long (seconds) rest.
LOW, STILL, LONG = 0.75, 0.12, 0.5


@dataclass(frozen=True, eq=False)
class Retargeted:
    """A take on a rig.

    motion: of a body of the rig's proportions. location: (T, 3) of the pelvis bone, and rotations: (T, K, 4) of the
    fit's links, in the channels of their pose bones. planned: (T, 2, 3) places of the ankles, right one first, in the
    frames of stands: (T, 2) flags.
    """

    fit: Fit
    motion: Motion
    location: np.ndarray
    rotations: np.ndarray
    planned: np.ndarray
    stands: np.ndarray

    def missed(self) -> float:
        """Return the greatest distance of a standing foot from its planned place, which its leg does not reach."""
        positions, _ = self.motion.forward_kinematics()
        away = np.linalg.norm(positions[:, [foot.ankle for foot in FEET]] - self.planned, axis=-1)
        return float(away[self.stands].max(initial=0.0))


def retarget(
    motion: Motion, rig: Rig, bones: Mapping[str, str], skin: np.ndarray | None = None
) -> Retargeted:
    """Retarget a take to a rig.

    bones: joint -> bone name. skin: (N, 3) of the take's own body in the T-pose, the pelvis at the origin, if known.
    Raises SampError where the bones are not those of a body.
    """
    motion = replace(motion, rotations=complete(motion.rotations))
    fitted = fit(rig, bones, motion.rest_joints)
    prints = Footprints.of(motion)
    plans = plan_feet(motion, prints)
    body = replace(motion, root=_root(motion, fitted, prints, skin), rest_joints=_rest_joints(fitted))
    body = _follow_feet(body, motion, plans)
    planned = plan_feet(body, prints, known=plans)
    body = lock_to_plans(body, planned, prints)
    location, rotations = _channels(body, rig, fitted)
    return Retargeted(
        fit=fitted,
        motion=body,
        location=location,
        rotations=rotations,
        planned=np.stack([plan.ankle for plan in planned], axis=1),
        stands=np.stack([plan.standing for plan in planned], axis=1),
    )


def _rest_joints(fitted: Fit) -> np.ndarray:
    """Return the rig's joints (55, 3) with the balls of the feet BALL_HEIGHT over the soles.

    The foot lock assumes this; in a rig they can be anywhere.
    """
    joints = fitted.joints.copy()
    for foot in FEET:
        joints[foot.ball, 1] = joints[foot.ankle, 1] - fitted.sole + BALL_HEIGHT
    return joints


def sole_height(joints: np.ndarray) -> float:
    """Return the height of the soles of joints (55, 3) in the T-pose."""
    return float(np.mean([joints[foot.ball, 1] for foot in FEET])) - BALL_HEIGHT


def _root(motion: Motion, fitted: Fit, prints: Footprints, skin: np.ndarray | None) -> np.ndarray:
    """Return the pelvis positions (T, 3) of the rig, its hips over the same place of the floor as the take's.

    Their height is that of the legs while the body stands, that of the body over the seat while it rests, and
    interpolated between the two. skin: see retarget.
    """
    source, target = motion.rest_joints, _rest_joints(fitted)
    positions, globals_ = motion.forward_kinematics()
    middle = hips(positions)
    ground = prints.height(len(motion))
    over = middle[:, 1] - ground
    tall, taller = (float(hips(joints)[1] - sole_height(joints)) for joints in (source, target))
    standing = over * (taller / tall - 1)
    thick = None if skin is None or fitted.seat is None else seat_depth(skin, source)
    if thick is None:
        seated = SEAT * (leg_length(target) - leg_length(source))
    else:
        seated = fitted.seat - thick
    middle[:, 1] += hip_lift(over, _resting(motion, over / tall), standing, seated, tall)
    return middle - rotation.rotate(globals_[:, 0], np.broadcast_to(hips(target), middle.shape))


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
    """Move the feet of the rig's motion to those of the take while they stand or step.

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


def _channels(body: Motion, rig: Rig, fitted: Fit) -> tuple[np.ndarray, np.ndarray]:
    """Return the location (T, 3) of the pelvis bone and the rotations (T, K, 4) of the links, as pose channels."""
    _, globals_ = body.forward_kinematics()
    turns = np.empty((len(body), len(fitted.links), 4))
    for k, link in enumerate(fitted.links):
        below, above = (globals_[:, skeleton.INDEX[joint]] for joint in (link.below, link.above))
        turned = above if link.share == 1.0 else rotation.slerp(below, above, link.share)
        turns[:, k] = rotation.multiply(turned, fitted.aligned[k])
    border = rotation.matrix_to_quaternion(rig.turn.T @ frames.BLENDER_FROM_NETWORK @ fitted.axes.T)
    result = np.empty_like(turns)
    for k, (link, parent) in enumerate(zip(fitted.links, fitted.parents, strict=True)):
        own = turns[:, k]
        if parent >= 0:
            own = rotation.multiply(rotation.conjugate(turns[:, parent]), own)
        own = rotation.change_basis(own, fitted.axes)
        if parent < 0:
            own = rotation.multiply(border, own)
        result[:, k] = rotation.change_basis(own, rig.bases[link.bone].T)
    pelvis = fitted.links[0].bone
    head = body.root + rotation.rotate(globals_[:, 0], np.broadcast_to(fitted.pelvis_bone, body.root.shape))
    inverse = np.linalg.inv(rig.world)
    place = frames.to_blender(head) @ inverse[:3, :3].T + inverse[:3, 3]
    return (place - rig.heads[pelvis]) @ rig.bases[pelvis], result
