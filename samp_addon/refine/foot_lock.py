"""Foot lock: while a foot bears weight its ball stays where it is, it clears the floor on its way to the next stance,
and no sole sinks into the floor."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d, uniform_filter1d

from .. import rotation, skeleton
from ..easing import smoothstep
from ..motion import CONTACTS, Motion
from .inverse_kinematics import STRETCH, at_height, solve_limb

BALL_HEIGHT = 0.0276  # of the ball joint over the sole, default human, metres
HEEL_BACK = 0.045  # from the ankle joint to the heel, metres
TOE_AHEAD = 0.06  # from the ball joint to the tip of the toes, metres
CLEARANCE = 0.036  # metres between the sole of a swinging foot and the floor
FULL_STEP = 0.25  # metres of way from which a step has all of the clearance; shorter ones have less
LOW = 0.01  # metres of wanted clearance under which a lift fades out
RISE = 5.0  # frames at 30 fps in which a foot gets there, and comes down again
UNLOCK_RADIUS = 0.12  # a foot that drifts further than this in one stance has really stepped
SWING_SPEED = 0.45  # m/s: a faster foot is in the air, whatever its label says
STEP_TIME = 0.3  # seconds that a foot takes from one lock to the next within one spell of contact
BLEND = 7  # frames at 30 fps over which a correction fades in and out
MOST_DROP = 0.06  # metres the pelvis may sink so that a leg reaches its lock


@dataclass(frozen=True)
class Foot:
    side: str
    column: int

    @property
    def ankle(self) -> int:
        return skeleton.INDEX[f"{self.side}_ankle"]

    @property
    def ball(self) -> int:
        return skeleton.INDEX[f"{self.side}_foot"]

    @property
    def hip(self) -> int:
        return skeleton.INDEX[f"{self.side}_hip"]


FEET = tuple(Foot(side, CONTACTS.index(f"{side}_foot")) for side in ("right", "left"))


def spells(mask: np.ndarray, shortest: int = 3, gap: int = 2) -> list[tuple[int, int]]:
    """Runs (first, last + 1) of a boolean mask (T,), gaps of up to ``gap`` frames closed, short runs dropped."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    runs: list[list[int]] = []
    for start, stop in edges.reshape(-1, 2):
        if runs and start - runs[-1][1] <= gap:
            runs[-1][1] = int(stop)
        else:
            runs.append([int(start), int(stop)])
    return [(a, b) for a, b in runs if b - a >= shortest]


def sole_points(
    positions: np.ndarray, globals_: np.ndarray, rest_joints: np.ndarray, side: str
) -> tuple[np.ndarray, np.ndarray]:
    """Lowest points of heel and ball of a foot, each (T, 3), from joints (T, J, 3) and global quaternions."""
    ankle, ball = skeleton.INDEX[f"{side}_ankle"], skeleton.INDEX[f"{side}_foot"]
    forward = (rest_joints[ball] - rest_joints[ankle]) * np.array([1.0, 0.0, 1.0])
    forward /= np.linalg.norm(forward)
    down = rest_joints[ball][1] - BALL_HEIGHT - rest_joints[ankle][1]
    heel = np.array([0.0, down, 0.0]) - HEEL_BACK * forward
    heel_world = positions[:, ankle] + rotation.rotate(
        globals_[:, ankle], np.broadcast_to(heel, positions[:, ankle].shape)
    )
    return heel_world, positions[:, ball] - np.array([0.0, BALL_HEIGHT, 0.0])


def toe_tips(positions: np.ndarray, globals_: np.ndarray, rest_joints: np.ndarray, side: str) -> np.ndarray:
    """Tip of the toes (T, 3) on the sole, from joints (T, J, 3) and global quaternions (T, J, 4)."""
    ankle, ball = skeleton.INDEX[f"{side}_ankle"], skeleton.INDEX[f"{side}_foot"]
    forward = (rest_joints[ball] - rest_joints[ankle]) * np.array([1.0, 0.0, 1.0])
    tip = TOE_AHEAD * forward / np.linalg.norm(forward) - np.array([0.0, BALL_HEIGHT, 0.0])
    return positions[:, ball] + rotation.rotate(
        globals_[:, ball], np.broadcast_to(tip, positions[:, ball].shape)
    )


def _clearance(ball: np.ndarray, stances: list[tuple[int, int]], fps: float) -> np.ndarray:
    """Height (T,) over the floor, metres, that a foot has at least between one stance and the next.

    ball: (T, 3), corrected. People drag their toes less than a network does that is never sure of its phase.
    """
    height = np.zeros(len(ball))
    for (_, before), (after, _) in zip(stances[:-1], stances[1:], strict=True):
        swing = after - before
        if swing < 3:
            continue
        way = np.linalg.norm(ball[after, [0, 2]] - ball[before - 1, [0, 2]])
        t = np.arange(1, swing + 1)
        rise = min(RISE * fps / 30, swing / 2.5)
        profile = smoothstep(np.minimum(t, swing + 1 - t) / (rise + 1))
        height[before:after] = CLEARANCE * min(1.0, way / FULL_STEP) * profile
    return height


def _stances(ball: np.ndarray, mask: np.ndarray, fps: float) -> list[tuple[int, int]]:
    """Spells of contact in which the ball (T, 3) is slow, split where it leaves the unlock radius.

    Around a split some frames are left free, in which the foot goes from one lock to the next.
    """
    velocity = np.gradient(ball[:, [0, 2]], 1 / fps, axis=0) if len(ball) > 1 else np.zeros((len(ball), 2))
    slow = uniform_filter1d(np.linalg.norm(velocity, axis=-1), 3, mode="nearest") < SWING_SPEED
    free = max(1, round(STEP_TIME * fps / 2))
    out = []
    places = ball[:, [0, 2]].tolist()
    for start, stop in spells(mask & slow):
        first, x, z = start, 0.0, 0.0  # sums since the first frame
        for t in range(start, stop):
            count = t - first
            if count > 0 and math.hypot(places[t][0] - x / count, places[t][1] - z / count) > UNLOCK_RADIUS:
                out.append((first, t - free))
                first, x, z = t + free, 0.0, 0.0
            if t >= first:
                x, z = x + places[t][0], z + places[t][1]
        out.append((first, stop))
    return [s for s in out if s[1] - s[0] >= 3]


def spread(offsets: np.ndarray, stances: list[tuple[int, int]], blend: int) -> np.ndarray:
    """Corrections (T, k), given inside the stances, carried smoothly through the swings between them."""
    out = offsets.copy()
    count = len(offsets)
    bounds = [(-1, 0), *stances, (count, count + 1)]
    for k in range(len(bounds) - 1):
        before, after = bounds[k][1] if k else 0, bounds[k + 1][0]
        gap = after - before
        if gap <= 0:
            continue
        left = offsets[before - 1] if k else np.zeros(offsets.shape[1])
        right = offsets[after] if k < len(stances) else np.zeros(offsets.shape[1])
        t = np.arange(1, gap + 1)[:, None]
        if k and k < len(stances) and gap <= 2 * blend:
            mix = smoothstep(t / (gap + 1))
            out[before:after] = left * (1 - mix) + right * mix
        else:
            fade_out = smoothstep(1 - t / (blend + 1))
            fade_in = smoothstep(1 - (gap + 1 - t) / (blend + 1))
            out[before:after] = left * fade_out + right * fade_in
    return out


def _corrections(motion: Motion, foot: Foot, floor: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far each frame's foot has to move (T, 3), and in which frames it stands (T,)."""
    positions, globals_ = motion.forward_kinematics()
    heel, ball = sole_points(positions, globals_, motion.rest_joints, foot.side)
    blend = max(2, round(BLEND * motion.fps / 30))
    stances = _stances(positions[:, foot.ball], motion.contacts[:, foot.column] > 0.5, motion.fps)
    offset = np.zeros((len(motion), 3))
    lowest = np.minimum(heel[:, 1], ball[:, 1]) - floor
    standing = np.zeros(len(motion), bool)
    for start, stop in stances:
        lock = positions[start:stop, foot.ball].mean(0)
        offset[start:stop] = lock - positions[start:stop, foot.ball]
        offset[start:stop, 1] = -lowest[start:stop]
        standing[start:stop] = True
    offset = spread(offset, stances, blend)
    toes = toe_tips(positions, globals_, motion.rest_joints, foot.side)[:, 1] - floor
    wanted = _clearance(positions[:, foot.ball] + offset, stances, motion.fps)
    lift = np.maximum(wanted - np.minimum(lowest, toes) - offset[:, 1], 0.0)
    # Smoothed, a lift would reach into the stances beside it.
    lift = gaussian_filter1d(lift, 1.5 * motion.fps / 30, mode="nearest") * np.minimum(wanted / LOW, 1.0)
    offset[:, 1] = np.where(standing, offset[:, 1], np.maximum(offset[:, 1] + lift, -lowest))
    return offset, standing


def lock_feet(motion: Motion, floor: np.ndarray | float = 0.0) -> Motion:
    """The motion with its stance feet pinned by inverse kinematics of the legs.

    motion.contacts must be set. floor: height of the support under the character, metres, one number or (T,).
    Where a pinned foot is out of the leg's reach the pelvis sinks a little, smoothly.
    """
    if motion.contacts is None:
        raise ValueError("foot lock needs the motion's contacts")
    floor = np.broadcast_to(np.asarray(floor, dtype=np.float64), len(motion))
    positions, _ = motion.forward_kinematics()
    plans = [(foot, *_corrections(motion, foot, floor)) for foot in FEET]
    root = motion.root - np.array([0.0, 1.0, 0.0]) * pelvis_drop(motion, positions, plans)[:, None]
    rotations = motion.rotations
    for foot, offset, _ in plans:
        target = positions[:, foot.ankle] + offset
        rotations = solve_limb(root, rotations, motion.rest_joints, f"{foot.side}_leg", target)
    for foot in FEET:
        rotations = bent_toes(root, rotations, motion.rest_joints, foot, floor)
    return replace(motion, root=root, rotations=rotations)


def bent_toes(
    root: np.ndarray, rotations: np.ndarray, rest: np.ndarray, foot: Foot, floor: np.ndarray
) -> np.ndarray:
    """Local rotations (T, J, 4) whose toes bend up as far as they would else be in the floor (T,)."""
    positions, globals_ = skeleton.forward_kinematics(root, rotations, rest)
    tip = toe_tips(positions, globals_, rest, foot.side)
    sinks = np.maximum(floor - tip[:, 1], 0.0)
    if not sinks.any():
        return rotations
    toes = tip - positions[:, foot.ball]
    height = np.minimum(toes[:, 1] + sinks, 0.98 * np.linalg.norm(toes, axis=-1))
    raised = at_height(toes, height, toes[:, [0, 2]])
    bend = rotation.multiply(rotation.between(toes, raised), globals_[:, foot.ball])
    rotations = rotations.copy()
    rotations[:, foot.ball] = rotation.multiply(rotation.conjugate(globals_[:, foot.ankle]), bend)
    return rotations


def pelvis_drop(motion: Motion, positions: np.ndarray, plans: list) -> np.ndarray:
    """How far the pelvis sinks (T,) so that standing feet are in reach, metres."""
    rest = motion.rest_joints
    drop = np.zeros(len(motion))
    for foot, offset, standing in plans:
        knee = skeleton.INDEX[f"{foot.side}_knee"]
        reach = STRETCH * (
            np.linalg.norm(rest[knee] - rest[foot.hip]) + np.linalg.norm(rest[foot.ankle] - rest[knee])
        )
        away = positions[:, foot.hip] - (positions[:, foot.ankle] + offset)
        flat = np.linalg.norm(away[:, [0, 2]], axis=-1)
        need = away[:, 1] - np.sqrt(np.maximum(reach**2 - flat**2, 0.0))
        drop = np.maximum(drop, np.where(standing, np.clip(need, 0.0, MOST_DROP), 0.0))
    window = max(3, round(5 * motion.fps / 30)) | 1
    padded = np.pad(drop, window, mode="edge")
    widest = np.max([np.roll(padded, k) for k in range(-(window // 2), window // 2 + 1)], axis=0)
    kernel = np.hanning(window + 2)[1:-1]
    return np.convolve(widest, kernel / kernel.sum(), "same")[window:-window]
