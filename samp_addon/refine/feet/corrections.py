"""Corrections of feet, spread over the swings between stances, and applied to the legs. Network frame, metres."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ... import rotation, skeleton
from ...easing import smoothstep
from ...motion import Motion
from ..inverse_kinematics import STRETCH, at_height, solve_limb
from .foot import Foot, toe_tips
from .stances import Stance

FULL_STEP = 0.25  # metres between two stances from which a swing has all of its clearance
RISE = 5.0  # frames at 30 fps in which a swinging foot reaches its clearance
SNAP, SNAP_SIGMA = 0.004, 1.0
"""Metres by which a hip may be farther from its ankle than on average around that frame, and the sigma, in frames at
30 fps, of the Gaussian that averages."""
MAX_DROP = 0.06  # metres that the pelvis may sink so that a leg reaches its target


@dataclass(frozen=True)
class Correction:
    """The correction of one foot.

    offset: (T, 3) by which its ankle moves. standing: (T,) flags of its stances. orientation: (T, 4) global
    quaternions of the ankle afterwards; None keeps them.
    """

    foot: Foot
    offset: np.ndarray
    standing: np.ndarray
    orientation: np.ndarray | None = None


def spread(values: np.ndarray, stances: Sequence[Stance], blend: int) -> np.ndarray:
    """Blend corrections (T, k) that are given inside the stances smoothly through the swings between them.

    Swings of up to 2 ``blend`` frames are interpolated; in longer ones each side fades over ``blend`` frames.
    """
    out = values.copy()
    count = len(values)
    bounds = [(-1, 0), *((stance.first, stance.last) for stance in stances), (count, count + 1)]
    for k in range(len(bounds) - 1):
        before, after = bounds[k][1] if k else 0, bounds[k + 1][0]
        gap = after - before
        if gap <= 0:
            continue
        left = values[before - 1] if k else np.zeros(values.shape[1])
        right = values[after] if k < len(stances) else np.zeros(values.shape[1])
        t = np.arange(1, gap + 1)[:, None]
        if k and k < len(stances) and gap <= 2 * blend:
            mix = smoothstep(t / (gap + 1))
            out[before:after] = left * (1 - mix) + right * mix
        else:
            fade_out = smoothstep(1 - t / (blend + 1))
            fade_in = smoothstep(1 - (gap + 1 - t) / (blend + 1))
            out[before:after] = left * fade_out + right * fade_in
    return out


def carried_on(values: np.ndarray, stances: Sequence[Stance], blend: int) -> np.ndarray:
    """Return what to add to corrections (T, k) that `spread` has faded over ``blend`` frames, so that they go on beside
    stances at the rate that they have inside.

    A foot then leaves its place, and arrives at the next one, without a jump of its speed.
    """
    out = np.zeros_like(values)
    count = len(values)
    for k, stance in enumerate(stances):
        if stance.last - stance.first < 2:
            continue
        before = stance.first - (stances[k - 1].last if k else 0)
        after = (stances[k + 1].first if k + 1 < len(stances) else count) - stance.last
        inside = values[stance.first : stance.last]
        for gap, rate, edge, way in (
            (before, inside[0] - inside[1], stance.first - 1, -1),
            (after, inside[-1] - inside[-2], stance.last, 1),
        ):
            span = gap if gap <= 2 * blend else blend
            t = np.arange(1, span + 1)
            out[edge + way * (t - 1)] += (t * (1 - t / (span + 1)) ** 2)[:, None] * rate
    return out


def swing_clearance(
    places: np.ndarray, stances: Sequence[Stance], fps: float, clearance: float
) -> np.ndarray:
    """Return the least height (T,) of the sole over the ground between stances; 0 inside them.

    places: (T, 3) of the foot. clearance: that of a full step; shorter steps have less.
    """
    height = np.zeros(len(places))
    for before, after in zip(stances[:-1], stances[1:], strict=True):
        swing = after.first - before.last
        if swing < 3:
            continue
        length = np.linalg.norm((places[after.first] - places[before.last - 1])[[0, 2]])
        t = np.arange(1, swing + 1)
        rise = min(RISE * fps / 30, swing / 2.5)
        profile = smoothstep(np.minimum(t, swing + 1 - t) / (rise + 1))
        height[before.last : after.first] = clearance * min(1.0, length / FULL_STEP) * profile
    return height


def apply(
    motion: Motion,
    corrections: Sequence[Correction],
    ground: Callable[[np.ndarray], np.ndarray],
    drop_share: np.ndarray | float = 1.0,
    eased: bool = False,
) -> Motion:
    """Move the feet by their corrections, by inverse kinematics of the legs, and bend toes out of the ground.

    ground: returns the heights (T,) of the ground at the tips of the toes (T, 3). drop_share: (T,) or one number,
    share of the pelvis drop that is applied where a standing foot is out of reach. eased: whether a leg may stay short
    of its target for a frame or two, so that its knee does not snap.
    """
    positions, _ = motion.forward_kinematics()
    rest = motion.rest_joints
    drop = drop_share * pelvis_drop(motion, positions, corrections)
    root = motion.root - np.array([0.0, 1.0, 0.0]) * drop[:, None]
    rotations = motion.rotations
    for one in corrections:
        target = positions[:, one.foot.ankle] + one.offset
        if eased:
            hip = positions[:, one.foot.hip] - np.array([0.0, 1.0, 0.0]) * drop[:, None]
            target = _without_snaps(hip, target, _leg_length(rest, one.foot), motion.fps)
        rotations = solve_limb(root, rotations, rest, f"{one.foot.side}_leg", target)
        if one.orientation is not None:
            rotations = _turn_ankle(root, rotations, rest, one.foot, one.orientation)
    for one in corrections:
        rotations = bend_toes(root, rotations, rest, one.foot, ground)
    return replace(motion, root=root, rotations=rotations)


def pelvis_drop(motion: Motion, positions: np.ndarray, corrections: Sequence[Correction]) -> np.ndarray:
    """Return how far the pelvis sinks (T,), smoothly, so that the legs of standing feet reach their targets.

    positions: (T, J, 3) of the joints.
    """
    rest = motion.rest_joints
    drop = np.zeros(len(motion))
    for one in corrections:
        foot = one.foot
        reach = STRETCH * _leg_length(rest, foot)
        leg = positions[:, foot.hip] - (positions[:, foot.ankle] + one.offset)
        flat = np.linalg.norm(leg[:, [0, 2]], axis=-1)
        need = leg[:, 1] - np.sqrt(np.maximum(reach**2 - flat**2, 0.0))
        drop = np.maximum(drop, np.where(one.standing, np.clip(need, 0.0, MAX_DROP), 0.0))
    window = max(3, round(5 * motion.fps / 30)) | 1
    padded = np.pad(drop, window, mode="edge")
    widest = np.max([np.roll(padded, k) for k in range(-(window // 2), window // 2 + 1)], axis=0)
    kernel = np.hanning(window + 2)[1:-1]
    return np.convolve(widest, kernel / kernel.sum(), "same")[window:-window]


def _leg_length(rest: np.ndarray, foot: Foot) -> float:
    """Return the length, metres, of a straight leg from hip to ankle. rest: (J, 3) rest joints."""
    return float(np.linalg.norm(np.diff(rest[[foot.hip, foot.knee, foot.ankle]], axis=0), axis=-1).sum())


def _without_snaps(hip: np.ndarray, target: np.ndarray, length: float, fps: float) -> np.ndarray:
    """Return targets (T, 3) of an ankle at which the leg does not snap straight from one frame to the next.

    Where the distance from the hip grows suddenly, the ankle stays behind its target for a frame or two. hip: (T, 3).
    target: (T, 3). length: metres of the straight leg.
    """
    leg = target - hip
    distance = np.linalg.norm(leg, axis=-1)
    reach = np.minimum(distance, STRETCH * length)
    eased = gaussian_filter1d(reach, SNAP_SIGMA * fps / 30, mode="nearest")
    return hip + leg * (np.minimum(reach, eased + SNAP) / np.maximum(distance, 1e-9))[:, None]


def bend_toes(
    root: np.ndarray,
    rotations: np.ndarray,
    rest: np.ndarray,
    foot: Foot,
    ground: Callable[[np.ndarray], np.ndarray],
) -> np.ndarray:
    """Return local rotations (T, J, 4) whose toes bend up as far as they would otherwise be in the ground.

    ground: returns the heights (T,) of the ground at the tips of the toes (T, 3).
    """
    positions, globals_ = skeleton.forward_kinematics(root, rotations, rest)
    tip = toe_tips(positions, globals_, rest, foot.side)
    depth = np.maximum(ground(tip) - tip[:, 1], 0.0)
    if not depth.any():
        return rotations
    toes = tip - positions[:, foot.ball]
    height = np.minimum(toes[:, 1] + depth, 0.98 * np.linalg.norm(toes, axis=-1))
    raised = at_height(toes, height, toes[:, [0, 2]])
    bend = rotation.multiply(rotation.between(toes, raised), globals_[:, foot.ball])
    rotations = rotations.copy()
    rotations[:, foot.ball] = rotation.multiply(rotation.conjugate(globals_[:, foot.ankle]), bend)
    return rotations


def _turn_ankle(
    root: np.ndarray, rotations: np.ndarray, rest: np.ndarray, foot: Foot, orientation: np.ndarray
) -> np.ndarray:
    """Return local rotations (T, J, 4) whose ankle has these global quaternions (T, 4)."""
    _, globals_ = skeleton.forward_kinematics(root, rotations, rest)
    rotations = rotations.copy()
    rotations[:, foot.ankle] = rotation.multiply(rotation.conjugate(globals_[:, foot.knee]), orientation)
    return rotations
