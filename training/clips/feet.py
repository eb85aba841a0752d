"""Feet of a retargeted clip: floor height from standing feet, contacts, locked heels and balls, bent toes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d, minimum_filter1d, uniform_filter1d

from ...samp_addon import rotation, skeleton
from ...samp_addon.easing import smoothstep
from ...samp_addon.motion import Motion
from ...samp_addon.refine.feet.corrections import Correction, pelvis_drop, spread
from ...samp_addon.refine.feet.foot import BALL_HEIGHT, FEET, TOE_AHEAD, Foot, sole_points, toe_tips
from ...samp_addon.refine.feet.stances import Stance
from ...samp_addon.refine.inverse_kinematics import solve_limb
from ...samp_addon.refine.runs import runs

SIDES = ("left", "right")
SLOW, LOW = 0.40, 0.055  # highest speed (m/s) and height (m) of a ball in contact
HEEL_SLOW, HEEL_LOW = 0.85, 0.75  # factors on these for a heel
RUN = 2.0  # pelvis speed (m/s) above which contacts are blurred at 30 frames a second
RUN_SLOW, RUN_LOW = 0.25, 0.065  # then: share of the pelvis' speed, and height (m), of a ball in contact
SHORTEST, GAP = 4, 2  # frames: shortest contact, longest gap in it that is closed
PLANTED = 0.35  # highest speed (m/s) of a ball from which the floor is estimated
CLEARANCE = 0.02  # metres between the floor and the lowest point of a swinging foot; its skin is 5 mm lower
FULL_STEP = 0.25  # step length (m) from which the clearance is applied in full
RISE, SMALL = (
    4.0,
    0.005,
)  # frames in which a foot reaches the clearance, and metres of clearance below which a lift fades
TOES_FREE = 0.05  # height (m) of the ball from which toes are not bent
MOST_BEND = np.radians(60.0)
CARRIED = 2.0  # frames, sigma of the pelvis' correction, which follows those of standing feet
EVEN = 0.4  # frames, sigma of the smoothing of foot corrections
BLEND = 7  # frames over which a correction fades outside contacts
SETTLED, OVER = 0.12, 0.03  # highest speed (m/s) and height (m) of a point in contact after the lock
MOST_SINK = 0.25  # metres by which a lying body is lowered onto the floor, at most
LYING_RADII = {"pelvis": 0.105, "hip": 0.10, "spine1": 0.105, "spine2": 0.11, "spine3": 0.115, "neck": 0.06,
               "head": 0.09, "knee": 0.055, "ankle": 0.04, "collar": 0.08, "shoulder": 0.065, "elbow": 0.042,
               "wrist": 0.03, "foot": 0.03}  # fmt: skip
"""Distance from a joint to the skin under it, metres."""


def soles(motion: Motion) -> np.ndarray:
    """Return the lowest points (T, 4, 3) of left heel, left ball, right heel, right ball, metres."""
    positions, globals_ = motion.forward_kinematics()
    return np.stack(
        [point for side in SIDES for point in sole_points(positions, globals_, motion.rest_joints, side)], 1
    )


def flat_speed(points: np.ndarray, fps: float) -> np.ndarray:
    """Return the horizontal speed (T, ...), m/s, of points (T, ..., 3)."""
    if len(points) < 2:
        return np.zeros(points.shape[:-1])
    return np.linalg.norm(np.gradient(points[..., [0, 2]], 1 / fps, axis=0), axis=-1)


def touching(motion: Motion) -> np.ndarray:
    """Return contact flags (T, 4) of heels and balls that are low and slow; the floor is at y = 0."""
    points = soles(motion)
    pace = uniform_filter1d(flat_speed(motion.root, motion.fps), 15, mode="nearest")
    running = pace > RUN
    speed = uniform_filter1d(flat_speed(points, motion.fps), 3, axis=0, mode="nearest")
    result = np.zeros(points.shape[:2], bool)
    for k in range(4):
        slower, lower = (HEEL_SLOW, HEEL_LOW) if k % 2 == 0 else (1.0, 1.0)
        near = speed[:, k] < slower * np.maximum(SLOW, RUN_SLOW * pace)
        near &= points[:, k, 1] < lower * np.where(running, RUN_LOW, LOW)
        for start, stop in runs(near, SHORTEST - 1, GAP):
            if stop - start >= SHORTEST or running[start:stop].all():
                result[start:stop, k] = True
    return result


def floor_height(motion: Motion, lying: np.ndarray | None = None) -> float:
    """Return the height of the floor, metres: the median of the lower sole points of slow feet at their lowest.

    lying: (T,) flags of frames to leave out. Where no foot is slow, as in a run, the low points of the feet's paths
    are used.
    """
    points = soles(motion)
    counts = np.ones(len(motion), bool) if lying is None else ~lying
    low = np.minimum(points[:, 0::2, 1], points[:, 1::2, 1])  # of both feet (T, 2)
    slow = (flat_speed(points[:, 1::2], motion.fps) < PLANTED) & counts[:, None]
    planted = []
    for foot in range(2):
        mine = slow[:, foot]
        if mine.sum() > 5:
            mine = mine & (low[:, foot] < np.percentile(low[mine, foot], 30) + 0.06)
        planted.append(low[mine, foot])
    heights = np.concatenate(planted)
    if len(heights) <= max(5, 0.25 * counts.sum()):
        turning = (low <= minimum_filter1d(low, 9, axis=0)) & counts[:, None]
        lowest = low[counts].min() if counts.any() else 0.0
        heights = low[turning & (low < lowest + 0.06)]
    return float(np.median(heights)) if len(heights) else 0.0


def lowest(motion: Motion) -> np.ndarray:
    """Return the height (T,), metres, of the lowest point of the body, with joints taken as balls."""
    positions, _ = motion.forward_kinematics()
    radii = [LYING_RADII[name.split("_")[-1]] for name in skeleton.BODY_JOINTS]
    body = (positions[:, : skeleton.BODY_COUNT, 1] - np.array(radii)).min(1)
    return np.minimum(body, soles(motion)[..., 1].min(1))


def grounded(motion: Motion, lying: np.ndarray | None = None) -> Motion:
    """Return the motion with its floor at y = 0, and the body on the floor in frames flagged lying (T,)."""
    up = np.array([0.0, 1.0, 0.0])
    motion = replace(motion, root=motion.root - up * floor_height(motion, lying))
    if lying is None or not lying.any():
        return motion
    height = lowest(motion)
    weight = uniform_filter1d(maximum_filter1d(lying.astype(float), 3), 15, mode="nearest")
    weight = np.ones(len(motion)) if lying.all() else weight
    off = np.clip(height, None, MOST_SINK) * weight + np.minimum(height, 0) * (1 - weight)
    off = uniform_filter1d(minimum_filter1d(off, 5, mode="nearest"), 7, mode="nearest")
    return replace(motion, root=motion.root - up * off[:, None])


def locked(motion: Motion, contact: np.ndarray) -> Motion:
    """Return the motion with heels and balls locked during contact (T, 4), soles on the floor, toes bent.

    Where a leg is too short to reach its locked foot, the pelvis is lowered.
    """
    positions, globals_ = motion.forward_kinematics()
    points = soles(motion)
    corrections = []
    for foot in FEET:
        k = 2 * SIDES.index(foot.side)
        offset, stands = _held(points[:, k : k + 2], contact[:, k : k + 2])
        tips = toe_tips(positions, globals_, motion.rest_joints, foot.side)[:, 1]
        low = np.minimum(points[:, k : k + 2, 1].min(1), tips) + offset[:, 1]
        offset[:, 1] += _lift(low, points[:, k + 1] + offset, stands)
        corrections.append(Correction(foot, offset, stands))
    up = np.array([0.0, 1.0, 0.0])
    carried = motion.root + up * _carried(corrections)[:, None]
    positions = positions + (carried - motion.root)[:, None]
    corrections = [replace(one, offset=one.offset - (carried - motion.root)) for one in corrections]
    root = carried - up * pelvis_drop(motion, positions, corrections)[:, None]
    local = motion.rotations
    for one in corrections:
        target = positions[:, one.foot.ankle] + one.offset
        local = solve_limb(root, local, motion.rest_joints, f"{one.foot.side}_leg", target)
    for one in corrections:
        local = flat_toes(root, local, motion.rest_joints, one.foot)
    return replace(motion, root=root, rotations=rotation.continuous(rotation.normalise(local)))


def _carried(corrections: list[Correction]) -> np.ndarray:
    """Return the rise (T,) of the pelvis, metres, with the feet that carry it.

    This preserves the knees' flexion: in a nearly straight knee, a centimetre is eight degrees.
    """
    weight = np.sum([one.standing.astype(float) for one in corrections], axis=0)
    total = np.sum([one.offset[:, 1] * one.standing for one in corrections], axis=0)
    blurred = lambda values: gaussian_filter1d(values, CARRIED, mode="nearest")
    return blurred(total) / np.maximum(blurred(weight), 1e-3)


def flat_toes(root: np.ndarray, local: np.ndarray, rest: np.ndarray, foot: Foot) -> np.ndarray:
    """Return local rotations (T, J, 4) with toes flat where the ball is on the floor, and never inside it.

    Toes bend about the foot's own lateral axis.
    """
    positions, globals_ = skeleton.forward_kinematics(root, local, rest)
    ahead = (rest[foot.ball] - rest[foot.ankle]) * np.array([1.0, 0.0, 1.0])
    ahead = ahead / np.linalg.norm(ahead)
    pointing = rotation.rotate(globals_[:, foot.ball], np.broadcast_to(ahead, root.shape))
    down = np.arcsin(np.clip(-pointing[:, 1], -1.0, 1.0))
    height = np.maximum(positions[:, foot.ball, 1] - BALL_HEIGHT, 0.0)
    flat = np.clip(1 - height / TOES_FREE, 0.0, 1.0) * np.clip(down, 0.0, None)
    into = down - np.arcsin(np.clip(height / TOE_AHEAD, -1.0, 1.0))
    bend = gaussian_filter1d(np.clip(np.maximum(flat, into), 0.0, MOST_BEND), 0.7, mode="nearest")
    axis = np.cross([0.0, 1.0, 0.0], ahead)
    local = local.copy()
    local[:, foot.ball] = rotation.multiply(
        local[:, foot.ball], rotation.from_axis_angle(-bend[:, None] * axis)
    )
    return local


def _held(points: np.ndarray, contact: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return offsets (T, 3), metres, that lock a foot, and flags (T,) of its stances.

    points: (T, 2, 3) and contact: (T, 2) of heel and ball. The ball is locked while in contact, else the heel; the
    change from one to the other is continuous.
    """
    count = len(points)
    stands = contact.any(1)
    offset = np.zeros((count, 3))
    stances = runs(stands, 1, 0)
    for start, stop in stances:
        held = np.where(contact[start:stop, 1], 1, 0)
        path = points[np.arange(start, stop), held]
        steps = np.diff(path, axis=0)
        # Between the two locked points the foot keeps its own motion.
        steps[held[1:] != held[:-1]] = 0.0
        inside = -np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
        offset[start:stop] = inside - inside.mean(0)
    offset = spread(offset, [Stance(*span) for span in stances], BLEND)
    low = points[..., 1].min(1)
    weight = np.maximum(stands, smoothstep(uniform_filter1d(stands.astype(float), 9, mode="nearest")))
    offset[:, 1] = -low * weight + np.maximum(-low, 0.0) * (1 - weight)
    offset = gaussian_filter1d(offset, EVEN, axis=0, mode="nearest")
    return offset, stands


def _lift(lowest_point: np.ndarray, ball: np.ndarray, stands: np.ndarray) -> np.ndarray:
    """Return the lift (T,), metres, with which a foot clears the floor between two stances.

    lowest_point: (T,) heights over the floor. ball: (T, 3) positions.
    """
    wanted = np.zeros(len(ball))
    stances = runs(stands, 1, 0)
    for (_, before), (after, _) in zip(stances[:-1], stances[1:], strict=True):
        swing = after - before
        if swing < 3:
            continue
        way = np.linalg.norm(ball[after, [0, 2]] - ball[before - 1, [0, 2]])
        t = np.arange(1, swing + 1)
        rise = min(RISE, swing / 2.5)
        profile = smoothstep(np.minimum(t, swing + 1 - t) / (rise + 1))
        wanted[before:after] = CLEARANCE * min(1.0, way / FULL_STEP) * profile
    lift = np.maximum(wanted - lowest_point, 0.0) * (wanted > 0)
    return gaussian_filter1d(lift, 1.0, mode="nearest") * np.minimum(wanted / SMALL, 1.0)


def settled(motion: Motion, contact: np.ndarray) -> np.ndarray:
    """Return the contacts (T, 4) that remain valid after the lock: points that neither slide nor float."""
    points = soles(motion)
    return contact & (flat_speed(points, motion.fps) < SETTLED) & (points[..., 1] < OVER)
