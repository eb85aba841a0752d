"""Feet that stand: where each foot is while it bears weight, on what is under it, and inverse kinematics to there.

Nothing is known of the motion but its joints: a foot stands where its sole is near the ground and slow (Long-term
motion, section 3.4: the nearer foot between two frames is the stable one). Network frame, metres.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import distance_transform_edt, gaussian_filter1d, uniform_filter1d

from .. import rotation, skeleton
from ..easing import anticipate, smoothstep
from ..motion import Motion
from . import weight
from .field import Field
from .foot_lock import BALL_HEIGHT, FEET, HEEL_BACK, Foot, bent_toes, pelvis_drop, spells, spread, toe_tips
from .inverse_kinematics import solve_limb

CLEARANCE = 0.03  # metres between the sole of a swinging foot and the ground
FULL_STEP = 0.25  # metres of way from which a step has all of it; shorter ones have less
RISE = 5.0  # frames of 30 a second in which a foot gets there
TOES = 0.07  # metres from the ball of the sole to the tip of the toes
NEAR_GROUND = 0.05  # metres between a standing sole and the ground
RISEN = 0.01  # metres that a sole is higher than in most of its stance when it has left the ground
SLOW = 0.40  # m/s of a sole that stands
STEPPED = 0.10  # metres of drift within a stance after which it is another one
FLAT = 0.035  # metres by which heel and ball of a flat foot differ in height over the ground
UPRIGHT = 0.75  # cosine between a standing foot's own up and the vertical
MOST_TILT = np.radians(25.0)  # by which a foot is laid onto its ground
ROLLED = np.radians(40.0)  # by which a foot has rolled over when it may turn as well
OVER = 0.002  # metres that a sole is held over the ground
BLEND = 6  # frames of 30 a second over which corrections fade
EVENLY = 0.75  # frames of 30 a second, standard deviation over which corrections are smoothed
SEATED, UPRIGHT_PELVIS = 0.7, 0.9  # heights of the pelvis over the ankles, in lengths of a leg
BRIDGED = 12  # frames of 30 a second in which neither foot stands that are shared between the two
SHORTEST = 4  # frames of 30 a second of a stance


@dataclass(frozen=True)
class Stance:
    """A foot that stands from frame first up to, not with, last; flat: the part of it with the whole sole down."""

    first: int
    last: int
    flat: tuple[int, int] | None


@dataclass(frozen=True)
class FootPlan:
    """Where a foot shall be. ankle: (T, 3) places and turned: (T, 4) global quaternions of the ankle joint.

    standing: (T,) flags. stances: its spells of standing.
    """

    foot: Foot
    ankle: np.ndarray
    turned: np.ndarray
    standing: np.ndarray
    stances: tuple[Stance, ...]


def ball(plan: FootPlan, motion: Motion) -> np.ndarray:
    """Where a plan has the ball joint of its foot (T, 3)."""
    bone = motion.rest_joints[plan.foot.ball] - motion.rest_joints[plan.foot.ankle]
    return plan.ankle + rotation.rotate(plan.turned, np.broadcast_to(bone, plan.ankle.shape))


def plan_feet(motion: Motion, field: Field, known: list[FootPlan] | None = None) -> list[FootPlan]:
    """Where both feet shall be, right one first. known: plans of the same take before it was changed, whose stances
    stay."""
    positions, globals_ = motion.forward_kinematics()
    seen = [_Seen.of(motion, foot, positions, globals_, field) for foot in FEET]
    if known is not None:
        stances = [plan.stances for plan in known]
    else:
        stances = [one.stances(motion.fps) for one in seen]
        stances = _bridged(stances, round(BRIDGED * motion.fps / 30), weight.carried(motion))
    return [one.plan(its) for one, its in zip(seen, stances, strict=True)]


def lowest_ground(motion: Motion, field: Field) -> float | None:
    """Height of the lowest ground that a foot stands on, metres; None where none does."""
    heights = []
    positions, globals_ = motion.forward_kinematics()
    for foot in FEET:
        seen = _Seen.of(motion, foot, positions, globals_, field)
        for stance in seen.stances(motion.fps):
            under = np.concatenate([ground[0][stance.first : stance.last] for ground in seen.grounds])
            heights += [float(np.nanmedian(under))] if np.isfinite(under).any() else []
    return min(heights, default=None)


def stand(motion: Motion, plans: list[FootPlan], field: Field) -> Motion:
    """The motion with its feet where they are planned; corrections fade through the steps between."""
    positions, globals_ = motion.forward_kinematics()
    blend, even = max(2, round(BLEND * motion.fps / 30)), EVENLY * motion.fps / 30
    wanted = []
    for plan, other in zip(plans, reversed(plans), strict=True):
        spans = [(stance.first, stance.last) for stance in plan.stances]
        offset = np.where(plan.standing[:, None], plan.ankle - positions[:, plan.foot.ankle], 0.0)
        turn = rotation.multiply(plan.turned, rotation.conjugate(globals_[:, plan.foot.ankle]))
        turn = np.where(plan.standing[:, None], rotation.to_axis_angle(rotation.continuous(turn)), 0.0)
        offset, turn = (
            gaussian_filter1d(spread(value, spans, blend), even, axis=0, mode="nearest")
            for value in (offset, turn)
        )
        turned = rotation.multiply(rotation.from_axis_angle(turn), globals_[:, plan.foot.ankle])
        offset[:, 1] += _lift(motion, plan, other, positions[:, plan.foot.ankle] + offset, turned, field)
        wanted.append((plan.foot, offset, plan.standing, turned))
    # Who sits or lies does not sink because a foot is out of reach.
    stands = smoothstep((_pelvis_over_feet(positions) - SEATED) / (UPRIGHT_PELVIS - SEATED))
    drop = stands * pelvis_drop(motion, positions, [entry[:3] for entry in wanted])
    root = motion.root - np.array([0.0, 1.0, 0.0]) * drop[:, None]
    rotations = motion.rotations
    for foot, offset, _, turned in wanted:
        target = positions[:, foot.ankle] + offset
        rotations = solve_limb(root, rotations, motion.rest_joints, f"{foot.side}_leg", target)
        rotations = _facing(root, rotations, motion.rest_joints, foot, turned)
    motion = replace(motion, root=root, rotations=rotations)
    for foot, *_ in wanted:
        ground = _ground_under_toes(motion, foot, field)
        rotations = bent_toes(root, motion.rotations, motion.rest_joints, foot, ground + OVER)
        motion = replace(motion, rotations=rotations)
    return motion


def _pelvis_over_feet(positions: np.ndarray) -> np.ndarray:
    """Metres (T,) of the pelvis over the lower ankle, of joints (T, J, 3), as a share of the legs' length."""
    ankles = [skeleton.INDEX[f"{side}_ankle"] for side in ("left", "right")]
    over = positions[:, 0, 1] - positions[:, ankles, 1].min(1)
    legs = np.linalg.norm(np.diff(positions[0][[1, 4, 7]], axis=0), axis=-1).sum()
    return over / legs


def _sole(rest: np.ndarray, side: str) -> tuple[np.ndarray, np.ndarray]:
    """Places (3,) of the sole's heel and ball in the frame of the ankle joint of the rest pose."""
    ankle, ball = rest[skeleton.INDEX[f"{side}_ankle"]], rest[skeleton.INDEX[f"{side}_foot"]]
    forward = (ball - ankle) * [1.0, 0.0, 1.0]
    forward /= np.linalg.norm(forward)
    down = np.array([0.0, ball[1] - BALL_HEIGHT - ankle[1], 0.0])
    return down - HEEL_BACK * forward, ball - ankle - [0.0, BALL_HEIGHT, 0.0]


@dataclass(frozen=True)
class _Seen:
    """A foot as it moves. ankle: (T, 3); turned: (T, 4); ends: heel and ball of the sole, (T, 3) each; grounds:
    heights (T,) and normals (T, 3) under each; sole: both ends in the ankle's frame."""

    foot: Foot
    ankle: np.ndarray
    turned: np.ndarray
    ends: list[np.ndarray]
    grounds: list[tuple[np.ndarray, np.ndarray]]
    sole: tuple[np.ndarray, np.ndarray]

    @classmethod
    def of(
        cls, motion: Motion, foot: Foot, positions: np.ndarray, globals_: np.ndarray, field: Field
    ) -> _Seen:
        ankle, turned = positions[:, foot.ankle], globals_[:, foot.ankle]
        sole = _sole(motion.rest_joints, foot.side)
        ends = [ankle + rotation.rotate(turned, np.broadcast_to(p, ankle.shape)) for p in sole]
        return cls(foot, ankle, turned, ends, [field.support(end) for end in ends], sole)

    def stances(self, fps: float) -> list[Stance]:
        over = [end[:, 1] - ground[0] for end, ground in zip(self.ends, self.grounds, strict=True)]
        up = rotation.rotate(self.turned, np.broadcast_to([0.0, 1.0, 0.0], self.ankle.shape))[:, 1]
        spans = _spans(self.ends, over, up, fps)
        return [Stance(first, last, _flat_part(over, first, last)) for first, last in spans]

    def plan(self, stances: Sequence[Stance]) -> FootPlan:
        place, facing, standing = self.ankle.copy(), self.turned.copy(), np.zeros(len(self.ankle), bool)
        for stance in stances:
            _pin(stance, place, facing, self.ends, self.grounds, self.sole)
            standing[stance.first : stance.last] = True
        return FootPlan(self.foot, place, facing, standing, tuple(stances))


def _bridged(feet: list[list[Stance]], most: int, carried: np.ndarray) -> list[list[Stance]]:
    """The stances of both feet, longer where for a few frames neither stood although the body was carried (T,): who
    walks always has a foot down."""
    order = sorted(
        (stance.first, stance.last, side, k) for side in (0, 1) for k, stance in enumerate(feet[side])
    )
    feet = [list(stances) for stances in feet]
    until, who = None, None
    for first, last, side, k in order:
        gap = 0 if until is None else first - until
        if 0 < gap <= most and who[0] != side and carried[until:first].mean() > 0.5:
            half = until + (gap + 1) // 2
            feet[who[0]][who[1]] = replace(feet[who[0]][who[1]], last=half)
            feet[side][k] = replace(feet[side][k], first=half)
        if until is None or last > until:
            until, who = last, (side, k)
    return feet


def _spans(
    ends: list[np.ndarray], over: list[np.ndarray], up: np.ndarray, fps: float
) -> list[tuple[int, int]]:
    """Spells (first, last + 1) of standing: the nearer end of the sole slow and near the ground."""
    if len(up) < 2:
        return []
    nearer = np.where((np.nan_to_num(over[0], nan=1.0) < np.nan_to_num(over[1], nan=1.0))[:, None], *ends)
    speed = np.min(
        [
            uniform_filter1d(np.linalg.norm(np.gradient(end, 1 / fps, axis=0), axis=-1), 3, mode="nearest")
            for end in ends
        ],
        axis=0,
    )
    low = np.nanmin(np.nan_to_num(np.abs(over), nan=1.0), axis=0)
    least = max(2, round(SHORTEST * fps / 30))
    found = []
    for first, last in spells((low < NEAR_GROUND) & (speed < SLOW) & (up > UPRIGHT), least, 2):
        down = np.flatnonzero(low[first:last] < np.percentile(low[first:last], 20) + RISEN)
        found += _split(ends[1], nearer, first + down[0], first + down[-1] + 1, least)
    return found


def _split(ball: np.ndarray, nearer: np.ndarray, first: int, last: int, least: int) -> list[tuple[int, int]]:
    """A spell cut where its ball has left where it stood; a foot needs some frames for a step."""
    out, start = [], first
    for t in range(first + 1, last):
        if t > start and np.linalg.norm((ball[t] - ball[start:t].mean(0))[[0, 2]]) > STEPPED:
            out.append((start, t - least))
            start = t + least
    return [(a, b) for a, b in [*out, (start, last)] if b - a >= least]


def _flat_part(over: list[np.ndarray], first: int, last: int) -> tuple[int, int] | None:
    """The longest part of a stance with heel and ball on the ground."""
    heel, ball = (np.nan_to_num(height[first:last], nan=1.0) for height in over)
    flat = (np.abs(heel - ball) < FLAT) & (np.maximum(heel, ball) < NEAR_GROUND)
    runs = spells(flat, 2, 1)
    if not runs:
        return None
    a, b = max(runs, key=lambda run: run[1] - run[0])
    return first + a, first + b


def _pin(
    stance: Stance,
    place: np.ndarray,
    facing: np.ndarray,
    ends: list[np.ndarray],
    grounds: list[tuple[np.ndarray, np.ndarray]],
    sole: tuple[np.ndarray, np.ndarray],
) -> None:
    """Writes a stance into the plan's ankle places and quaternions: whole foot still while flat, rolling about heel or
    ball before and after."""
    first, last = stance.first, stance.last
    a, b = stance.flat or (first, first)
    if stance.flat is not None:
        still, where, middle = _flat_foot(slice(a, b), facing, ends, grounds, sole)
        own = facing[first:last].copy()
        # Before and after it is flat the foot rolls as it did, from where it stands.
        base = np.clip(np.arange(first, last), a, b - 1) - first
        roll = _pitched(rotation.multiply(own, rotation.conjugate(own[base])), still, sole)
        facing[first:last] = rotation.multiply(roll, np.broadcast_to(still, roll.shape))
        facing[a:b] = still
        place[a:b] = where
    else:
        part = slice(first, last)
        middle = [end[part].mean(0) for end in ends]
        for at, end, ground in zip(middle, ends, grounds, strict=True):
            low = end[part, 1].min()
            at[1] = max(low, _height(ground, part, low) + OVER)
    for t in [*range(first, a), *range(b, last)]:
        corners = rotation.rotate(np.stack([facing[t], facing[t]]), np.stack(sole))
        pivot = int(corners[1, 1] < corners[0, 1])
        place[t] = middle[pivot] - corners[pivot]


def _pitched(roll: np.ndarray, still: np.ndarray, sole: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Rolls (N, 4) of a foot from where it stands as still (4,) says, without their twist and tilt while the sole
    has hardly left the ground: who rolls over heel or ball does not screw the sole into the floor."""
    heel, ball = rotation.rotate(np.stack([still, still]), np.stack(sole))
    across = np.cross([0.0, 1.0, 0.0], ball - heel)
    across /= np.linalg.norm(across)
    vector = rotation.to_axis_angle(rotation.continuous(roll))
    pitch = (vector @ across)[:, None] * across
    risen = smoothstep(np.linalg.norm(pitch, axis=-1, keepdims=True) / ROLLED)
    return rotation.from_axis_angle(pitch + risen * (vector - pitch))


def _flat_foot(
    part: slice,
    facing: np.ndarray,
    ends: list[np.ndarray],
    grounds: list[tuple[np.ndarray, np.ndarray]],
    sole: tuple[np.ndarray, np.ndarray],
) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """How a foot stands still on what is under it in some frames: the ankle's quaternion (4,) and place (3,), and the
    places of heel and ball."""
    still = rotation.normalise(rotation.continuous(facing[part]).mean(0))
    normal = np.mean([ground[1][part].mean(0) for ground in grounds], axis=0)
    length = np.linalg.norm(normal)
    normal = normal / length if length > 0.5 else np.array([0.0, 1.0, 0.0])  # no ground was near
    own_up = rotation.rotate(still[None], np.array([[0.0, 1.0, 0.0]]))
    tilt = rotation.to_axis_angle(rotation.between(own_up, normal[None]))
    tilt *= min(1.0, MOST_TILT / max(float(np.linalg.norm(tilt)), 1e-9))
    still = rotation.multiply(rotation.from_axis_angle(tilt), still[None])[0]
    corners = rotation.rotate(np.stack([still, still]), np.stack(sole))
    where = np.mean([end[part] for end in ends], axis=(0, 1)) - corners.mean(0)
    heights = [_height(ground, part, end[part, 1].mean()) for ground, end in zip(grounds, ends, strict=True)]
    where[1] = np.mean([height - corner[1] for height, corner in zip(heights, corners, strict=True)]) + OVER
    return still, where, [where + corner for corner in corners]


def _height(ground: tuple[np.ndarray, np.ndarray], part: slice, otherwise: float) -> float:
    """Mean height of the ground in some frames; that of the foot itself where no ground was near."""
    height = ground[0][part]
    return float(np.nanmean(height)) if np.isfinite(height).any() else float(otherwise)


def _lift(
    motion: Motion, plan: FootPlan, other: FootPlan, ankle: np.ndarray, turned: np.ndarray, field: Field
) -> np.ndarray:
    """Metres (T,) by which a foot on its way is raised so that its sole is not in the ground, and does not brush it
    while the other one stands: alone it may be what carries."""
    need = np.zeros(len(ankle))
    heel, ball = _sole(motion.rest_joints, plan.foot.side)
    clear = np.where(other.standing, _clearance(motion, plan, ankle), 0.0) + OVER
    for point in (heel, ball, ball + TOES * (ball - heel) / np.linalg.norm(ball - heel)):
        end = ankle + rotation.rotate(turned, np.broadcast_to(point, ankle.shape))
        ground, _ = field.support(end)
        need = np.maximum(need, np.nan_to_num(ground + clear - end[:, 1], nan=0.0))
    # Just after a stance a foot is raised no faster than feet leave the ground.
    need *= smoothstep(distance_transform_edt(~plan.standing) / (RISE * motion.fps / 30))
    lift = anticipate(need, 3, 2.0 * motion.fps / 30)
    lift[plan.standing] = 0.0
    return lift


def _clearance(motion: Motion, plan: FootPlan, ankle: np.ndarray) -> np.ndarray:
    """Metres (T,) that the sole of a foot is over the ground at least between two stances."""
    height = np.zeros(len(ankle))
    for before, after in zip(plan.stances[:-1], plan.stances[1:], strict=True):
        swing = after.first - before.last
        if swing < 3:
            continue
        way = np.linalg.norm((ankle[after.first] - ankle[before.last - 1])[[0, 2]])
        t = np.arange(1, swing + 1)
        rise = min(RISE * motion.fps / 30, swing / 2.5)
        profile = smoothstep(np.minimum(t, swing + 1 - t) / (rise + 1))
        height[before.last : after.first] = CLEARANCE * min(1.0, way / FULL_STEP) * profile
    return height


def _facing(
    root: np.ndarray, rotations: np.ndarray, rest: np.ndarray, foot: Foot, turned: np.ndarray
) -> np.ndarray:
    """Local rotations (T, J, 4) whose ankle has global quaternions (T, 4)."""
    _, globals_ = skeleton.forward_kinematics(root, rotations, rest)
    rotations = rotations.copy()
    knee = skeleton.PARENTS[foot.ankle]
    rotations[:, foot.ankle] = rotation.multiply(rotation.conjugate(globals_[:, knee]), turned)
    return rotations


def _ground_under_toes(motion: Motion, foot: Foot, field: Field) -> np.ndarray:
    """Heights (T,) of the ground at the tip of the toes; far below where there is none."""
    positions, globals_ = motion.forward_kinematics()
    tip = toe_tips(positions, globals_, motion.rest_joints, foot.side)
    return np.nan_to_num(field.support(tip)[0], nan=-1e3)
