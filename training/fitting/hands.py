"""Place the hands of a seated body on thighs, armrests or in the lap, outside the furniture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ...samp_addon import rotation, skeleton
from ...samp_addon.easing import smoothstep
from ...samp_addon.refine.inverse_kinematics import solve_limb
from ..mocap.clip_files import Clip
from .shapes import posing, probes
from .shapes.depth import PieceField
from .shapes.surfaces import SeatSurface
from .spreading import Phases, resting, sinking

ON_THIGH = (
    0.14,
    0.22,
)  # metres from wrist to thigh bone: below the first a hand rests on the thigh, above the second it does not
EVEN = 5.0  # frames, sigma
LIGHT_HOLD = 12  # frames at the beginning of the hold over which the hand moves to a new resting place
ON_ARMREST = 0.6  # share of the arms beside an armrest that are laid on it
WRIST_OVER = 0.038  # metres from the wrist joint to the skin under it
HAND = 0.09  # metres from the wrist to the centre of the palm
FREE = 0.012  # largest penetration of the furniture by an arm, metres
SIDES = ("left", "right")


def settled_hands(
    before: Clip,
    after: Clip,
    phases: Phases,
    surface: SeatSurface,
    field: PieceField,
    rng: np.random.Generator,
) -> tuple[Clip, np.ndarray]:
    """Return the fitted clip with its hands supported, and contacts (T, 2) of right and left hand with furniture.

    before: the captured clip, which defines when hands rest on the thighs.
    """
    clip = _with_thighs(before, after, sinking(before.root, phases))
    contacts = np.zeros((len(clip), 2))
    for column, side in ((1, "left"), (0, "right")):
        armrest = surface.armrests[0 if side == "left" else 1]
        if armrest is not None and rng.random() < ON_ARMREST:
            laid = _on_armrest(clip, phases, side, armrest, rng)
            if laid is not None and _arm_depth(laid[0], side, surface, field, phases) < FREE + field.give:
                clip, contacts[:, column] = laid
                continue
        if _arm_depth(clip, side, surface, field, phases) > FREE + field.give:
            clip = _tucked(clip, side, surface, field, phases)
    return clip, contacts


def _thigh_frames(clip: Clip, side: str) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return hips (T, 3), thighs' world rotations (T, 4), wrists (T, 3), and distances wrist to thigh (T,), metres."""
    positions, turned = skeleton.forward_kinematics(clip.root, clip.rotations, posing.REST)
    hip, knee, wrist = (positions[:, skeleton.INDEX[f"{side}_{name}"]] for name in ("hip", "knee", "wrist"))
    bone = knee - hip
    share = np.clip(((wrist - hip) * bone).sum(-1) / (bone**2).sum(-1), 0.0, 1.0)
    distance = np.linalg.norm(wrist - hip - share[:, None] * bone, axis=-1)
    return hip, turned[:, skeleton.INDEX[f"{side}_hip"]], wrist, distance


def _with_thighs(before: Clip, after: Clip, weight: np.ndarray) -> Clip:
    """Return the fitted clip with hands on the thighs wherever the captured ones were, by weight (T,)."""
    rotations = after.rotations
    for hand in SIDES:
        own = f"{hand}_wrist"
        hip_a, turn_a, wrist, own_distance = _thigh_frames(before, hand)
        hip_b, turn_b, now, _ = _thigh_frames(replace(after, rotations=rotations), hand)
        local = rotation.rotate(rotation.conjugate(turn_a), wrist - hip_a)
        there = hip_b + rotation.rotate(turn_b, local)
        on = smoothstep((ON_THIGH[1] - own_distance) / (ON_THIGH[1] - ON_THIGH[0])) * weight
        on = gaussian_filter1d(on, EVEN, mode="nearest")[:, None]
        if on.max() < 0.02:
            continue
        _, turned = skeleton.forward_kinematics(after.root, rotations, posing.REST)
        keep = turned[:, skeleton.INDEX[own]]
        rotations = solve_limb(after.root, rotations, posing.REST, f"{hand}_arm", now + on * (there - now))
        rotations = posing.end_turned(after.root, rotations, own, keep)
    return replace(after, rotations=rotation.continuous(rotations))


def _taken(clip: Clip, phases: Phases) -> np.ndarray:
    """Return the weight (T,) of a resting place, which is reached when seated and left before standing up."""
    frames = np.arange(len(clip))
    weight = smoothstep((frames - phases.seated + LIGHT_HOLD / 2) / (2.0 * LIGHT_HOLD))
    if phases.up_end > phases.seat_end:
        weight = np.minimum(weight, smoothstep((phases.seat_end - frames) / (1.5 * LIGHT_HOLD)))
    return weight


def _on_armrest(
    clip: Clip, phases: Phases, side: str, armrest: np.ndarray, rng: np.random.Generator
) -> tuple[Clip, np.ndarray] | None:
    """Return the clip with one forearm along an armrest, and its contact (T,); None where it cannot reach."""
    x, top, front, rear = armrest
    hold = phases.hold
    positions, turned = skeleton.forward_kinematics(clip.root, clip.rotations, posing.REST)
    shoulder = positions[:, skeleton.INDEX[f"{side}_shoulder"]]
    middle = np.median(shoulder[hold], axis=0)
    ahead = min(front - 0.06, middle[2] + rng.uniform(0.24, 0.34))
    if ahead - middle[2] < 0.12 or ahead < rear:
        return None
    target = np.array([x, top + WRIST_OVER, ahead])
    if np.linalg.norm(target - middle) > 0.98 * _arm_length():
        return None
    weight = _taken(clip, phases)
    # A small part of the captured wrist's motion remains, through the trunk.
    wrist = positions[:, skeleton.INDEX[f"{side}_wrist"]]
    goal = wrist + weight[:, None] * (target - wrist)
    out = 1.0 if side == "left" else -1.0
    rotations = solve_limb(clip.root, clip.rotations, posing.REST, f"{side}_arm", goal)
    flat = rotation.about_y(np.full(len(clip), -out * np.pi / 2))
    was = turned[:, skeleton.INDEX[f"{side}_wrist"]]
    flat = np.where((flat * was).sum(-1, keepdims=True) < 0, -flat, flat)
    rotations = posing.end_turned(clip.root, rotations, f"{side}_wrist", rotation.slerp(was, flat, weight))
    return replace(clip, rotations=rotation.continuous(rotations)), (weight > 0.9).astype(float)


def _arm_length() -> float:
    rest = posing.REST
    a, b, c = (skeleton.INDEX[f"left_{name}"] for name in ("shoulder", "elbow", "wrist"))
    return float(np.linalg.norm(rest[b] - rest[a]) + np.linalg.norm(rest[c] - rest[b]))


def _rows(clip: Clip, phases: Phases) -> np.ndarray:
    return np.arange(max(phases.down - 5, 0), min(phases.up_end + 5, len(clip)))[::8]


def _arm_depth(clip: Clip, side: str, surface: SeatSurface, field: PieceField, phases: Phases) -> float:
    """Return the largest penetration, metres, of an arm's skin into the piece, from sitting down to standing up."""
    rows = _rows(clip, phases)
    skin = probes.skinned(clip.root[rows], clip.rotations[rows], getattr(probes.load(), f"{side}_arm"))
    return float(field.skin_depth(surface.frame.to_piece(skin)).max())


def _tucked(clip: Clip, side: str, surface: SeatSurface, field: PieceField, phases: Phases) -> Clip:
    """Return the clip with one hand moved inwards and up just enough to free the arm; the best of a few tries."""
    positions, _ = skeleton.forward_kinematics(clip.root, clip.rotations, posing.REST)
    wrist = positions[:, skeleton.INDEX[f"{side}_wrist"]]
    weight = gaussian_filter1d(resting_or_sinking(clip, phases), EVEN, mode="nearest")[:, None]
    out = 1.0 if side == "left" else -1.0
    best, least = clip, _arm_depth(clip, side, surface, field, phases)
    for way in ((-0.05, 0.03, 0.05), (-0.10, 0.05, 0.08), (-0.16, 0.10, 0.14)):
        goal = wrist + weight * np.array([out * way[0], way[1], way[2]])
        rotations = solve_limb(clip.root, clip.rotations, posing.REST, f"{side}_arm", goal)
        rotations = _elbow_in(clip, rotations, side, -out * way[0] * 3, weight[:, 0])
        tried = replace(clip, rotations=rotations)
        deep = _arm_depth(tried, side, surface, field, phases)
        if deep < least:
            best, least = tried, deep
        if deep < FREE:
            break
    return best


def _elbow_in(clip: Clip, rotations: np.ndarray, side: str, angle: float, weight: np.ndarray) -> np.ndarray:
    """Return rotations with the elbow swivelled about the line shoulder to wrist by angle radians times weight (T,)."""
    positions, turned = skeleton.forward_kinematics(clip.root, rotations, posing.REST)
    a, c = (skeleton.INDEX[f"{side}_{name}"] for name in ("shoulder", "wrist"))
    axis = positions[:, c] - positions[:, a]
    axis /= np.maximum(np.linalg.norm(axis, axis=-1, keepdims=True), 1e-9)
    about = rotation.from_axis_angle(axis * (angle * weight)[:, None])
    out = rotations.copy()
    parent = turned[:, skeleton.PARENTS[a]]
    out[:, a] = rotation.multiply(rotation.conjugate(parent), rotation.multiply(about, turned[:, a]))
    return posing.end_turned(clip.root, out, f"{side}_wrist", turned[:, c])


def resting_or_sinking(clip: Clip, phases: Phases) -> np.ndarray:
    """Return the weight (T,) of being on the seat or close to it."""
    return np.maximum(sinking(clip.root, phases), resting(clip.root, phases))
