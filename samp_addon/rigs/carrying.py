"""A take carried to a rig: turns as they are, the pelvis as high as the rig's legs make it, the feet where they stood.

A rig in the T-pose is an SMPL-X body of other proportions (fitting.py). So a take for it is a Motion, and what mends
the feet of motions mends its feet. Network frame, metres.
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
from ..motion import CONTACTS, Motion
from ..refine.feet.foot import BALL_HEIGHT, FEET, HEEL_BACK, Foot
from ..refine.feet.foot_lock import lock_to_plans
from ..refine.feet.plan import FootPlan, plan_feet
from ..refine.inverse_kinematics import solve_limb
from ..refine.runs import runs
from .fitting import Fit, fit, hips, seat_depth
from .footprints import Footprints
from .rig import Rig

SEAT = 0.1  # share of a leg by which hips lie over their seat, where no skin tells
FOLLOW = 0.35  # seconds in which a foot is let go, or taken, beside a stance
SWING = 1.5  # seconds between two stances of a foot that still are one step
LOW, STILL, LONG = (
    0.75,
    0.12,
    0.5,
)  # legs high, m/s and seconds: hips so low and slow so long rest, if nothing tells


@dataclass(frozen=True, eq=False)
class Carried:
    """A take on a rig. motion: for a body of the rig's proportions. location: (T, 3) of the pelvis' bone and
    rotations: (T, K, 4) of the fit's links, as their pose bones have them. planned: (T, 2, 3) where the ankles
    shall be, right one first, and stands: (T, 2) in which frames."""

    fit: Fit
    motion: Motion
    location: np.ndarray
    rotations: np.ndarray
    planned: np.ndarray
    stands: np.ndarray

    def missed(self) -> float:
        """Metres by which a standing foot is at most not where it shall be: the leg does not reach."""
        positions, _ = self.motion.forward_kinematics()
        away = np.linalg.norm(positions[:, [foot.ankle for foot in FEET]] - self.planned, axis=-1)
        return float(away[self.stands].max(initial=0.0))


def carry(motion: Motion, rig: Rig, bones: Mapping[str, str], skin: np.ndarray | None = None) -> Carried:
    """The take for another rig. bones: joint -> bone. skin: (N, 3) of the take's own body in the T-pose, its pelvis
    at the origin, if it is known.

    Raises SampError where the bones are not those of a body.
    """
    motion = replace(motion, rotations=complete(motion.rotations))
    laid = fit(rig, bones, motion.rest_joints)
    prints = Footprints.of(motion)
    plans = plan_feet(motion, prints)
    body = replace(motion, root=_root(motion, laid, prints, skin), rest_joints=_standing_joints(laid))
    body = _following(body, motion, plans)
    planned = plan_feet(body, prints, known=plans)
    body = lock_to_plans(body, planned, prints)
    location, rotations = _channels(body, rig, laid)
    return Carried(
        fit=laid,
        motion=body,
        location=location,
        rotations=rotations,
        planned=np.stack([plan.ankle for plan in planned], axis=1),
        stands=np.stack([plan.standing for plan in planned], axis=1),
    )


def _standing_joints(laid: Fit) -> np.ndarray:
    """The rig's joints (55, 3), the balls of the feet as high over the soles as everything about feet takes them to
    be: a rig's own may be anywhere."""
    joints = laid.joints.copy()
    for foot in FEET:
        joints[foot.ball, 1] = joints[foot.ankle, 1] - laid.sole + BALL_HEIGHT
    return joints


def _sole_height(joints: np.ndarray) -> float:
    """Height of the soles of joints (55, 3) in the T-pose."""
    return float(np.mean([joints[foot.ball, 1] for foot in FEET])) - BALL_HEIGHT


def _root(motion: Motion, laid: Fit, prints: Footprints, skin: np.ndarray | None) -> np.ndarray:
    """Where the rig's pelvis is (T, 3): its hips over the same place of the floor as the take's. Who stands has them
    as high as the legs are long; who rests as high over the seat as the body is thick; between the two, between."""
    ours, theirs = motion.rest_joints, _standing_joints(laid)
    positions, globals_ = motion.forward_kinematics()
    middle = hips(positions)
    ground = prints.height(len(motion))
    over = middle[:, 1] - ground
    tall, taller = (float(hips(joints)[1] - _sole_height(joints)) for joints in (ours, theirs))
    standing_ = over * (taller / tall - 1)
    thick = None if skin is None or laid.seat is None else seat_depth(skin, ours)
    if thick is None:
        seated = SEAT * (leg_length(theirs) - leg_length(ours))
    else:
        seated = laid.seat - thick
    middle[:, 1] += _between(over, _resting(motion, over / tall), standing_, seated, tall)
    return middle - rotation.rotate(globals_[:, 0], np.broadcast_to(hips(theirs), middle.shape))


def _resting(motion: Motion, over: np.ndarray) -> np.ndarray:
    """In which frames (T,) the pelvis rests on something. over: (T,) the hips' height, in legs."""
    if motion.contacts is not None:
        return motion.contacts[:, CONTACTS.index("pelvis")] > 0.5
    if len(motion) < 2:
        return over < LOW
    speed = np.linalg.norm(np.gradient(motion.root, 1 / motion.fps, axis=0), axis=-1)
    still = (over < LOW) & (speed < STILL)
    return gaussian_filter1d(still.astype(float), LONG / 2 * motion.fps, mode="nearest") > 0.5


def _between(
    over: np.ndarray, resting: np.ndarray, standing_: np.ndarray, seated: float, tall: float
) -> np.ndarray:
    """Metres (T,) that the hips are raised: ``seated`` while they rest, ``standing_`` (T,) while they are as high over
    the ground as in most of the steps, at most ``tall``; on the way down and up in proportion to how far they are."""
    rests = runs(resting, 1, 0)
    if not rests:
        return standing_
    # The height from which, or to which, the hips go: that of the rest which is nearest in time.
    count = np.arange(len(over))
    away = [np.maximum(np.maximum(first - count, count - last + 1), 0) for first, last in rests]
    levels = np.array([np.median(over[first:last]) for first, last in rests])
    seat = levels[np.argmin(away, axis=0)]
    # Who stands does not stretch as far as the legs go.
    stands = np.clip(np.percentile(over[~resting], 80), 0.75 * tall, tall) if not resting.all() else tall
    share = np.clip((over - seat) / np.maximum(stands - seat, 0.1), 0.0, 1.0)
    return seated + share * (standing_ - seated)


def _following(body: Motion, motion: Motion, plans: list[FootPlan]) -> Motion:
    """The rig's take with its feet where the take's are while they stand or step; feet that hang or lie follow their
    legs. The middles of the soles are at the same place."""
    theirs, turned = motion.forward_kinematics()
    own, _ = body.forward_kinematics()
    rotations = body.rotations
    for plan in plans:
        foot = plan.foot
        shift = _sole_middle(motion.rest_joints, foot) - _sole_middle(body.rest_joints, foot)
        place = theirs[:, foot.ankle] + rotation.rotate(
            turned[:, foot.ankle], np.broadcast_to(shift, theirs[:, foot.ankle].shape)
        )
        share = _stepping(plan, len(motion), motion.fps)[:, None]
        target = share * place + (1 - share) * own[:, foot.ankle]
        rotations = solve_limb(body.root, rotations, body.rest_joints, f"{foot.side}_leg", target)
    return replace(body, rotations=rotations)


def _sole_middle(joints: np.ndarray, foot: Foot) -> np.ndarray:
    """The middle (3,) of a sole, from its ankle joint, in the T-pose."""
    ankle, ball = joints[foot.ankle], joints[foot.ball]
    forward = (ball - ankle) * [1.0, 0.0, 1.0]
    back = HEEL_BACK * forward / np.linalg.norm(forward)
    middle = (ball - ankle - back) / 2
    middle[1] = ball[1] - BALL_HEIGHT - ankle[1]
    return middle


def _stepping(plan: FootPlan, count: int, fps: float) -> np.ndarray:
    """1 (count,) where a foot stands or steps from one stance to the next, fading to 0 beside it."""
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


def _channels(body: Motion, rig: Rig, laid: Fit) -> tuple[np.ndarray, np.ndarray]:
    """The pelvis bone's location (T, 3) and the links' own rotations (T, K, 4), as pose bones have them."""
    _, globals_ = body.forward_kinematics()
    turns = np.empty((len(body), len(laid.links), 4))
    for k, link in enumerate(laid.links):
        below, above = (globals_[:, skeleton.INDEX[joint]] for joint in (link.below, link.above))
        turned = above if link.share == 1.0 else rotation.slerp(below, above, link.share)
        turns[:, k] = rotation.multiply(turned, laid.aligned[k])
    border = rotation.matrix_to_quaternion(rig.turn.T @ frames.BLENDER_FROM_NETWORK @ laid.axes.T)
    result = np.empty_like(turns)
    for k, (link, parent) in enumerate(zip(laid.links, laid.parents, strict=True)):
        own = turns[:, k]
        if parent >= 0:
            own = rotation.multiply(rotation.conjugate(turns[:, parent]), own)
        own = rotation.change_basis(own, laid.axes)
        if parent < 0:
            own = rotation.multiply(border, own)
        result[:, k] = rotation.change_basis(own, rig.bases[link.bone].T)
    pelvis = laid.links[0].bone
    head = body.root + rotation.rotate(globals_[:, 0], np.broadcast_to(laid.pelvis_bone, body.root.shape))
    inverse = np.linalg.inv(rig.world)
    place = frames.to_blender(head) @ inverse[:3, :3].T + inverse[:3, 3]
    return (place - rig.heads[pelvis]) @ rig.bases[pelvis], result
