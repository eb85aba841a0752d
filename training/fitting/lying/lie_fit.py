"""Fit composed lies to mattress, pillow and edge, frame by frame, by the skinned body."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d, grey_closing, map_coordinates

from ....samp_addon import rotation, skeleton
from ....samp_addon.easing import anticipate, smoothstep
from ....samp_addon.refine.inverse_kinematics import solve_limb
from ...mocap.clip_files import Clip
from ..shapes import posing, probes

CELL = 0.02
TOP = 0.26  # height (m) over the mattress up to which surfaces are lain on: pillows, not boards
BELOW = 0.12  # metres below the mattress that still belong to the top
PRESSED = 0.004  # compression of flesh, metres
ON_FLOOR = (0.10, 0.16)  # height (m) of an ankle: below the first a foot stands, above the second it does not
EVEN = 3.0  # frames, sigma
PASSES = 3
TRUNK = ("pelvis", "left_hip", "right_hip", "spine1", "spine2", "spine3")
LEVERS = {"chest": 0.30, "head": 0.20}
MOST = {"chest": np.radians(14), "head": np.radians(12)}
ON_SIDE = 0.6  # cosine between the chest's left and the vertical from which a body is on a side; legs are lowered more
FLAT, SITTING = 0.85, 0.35
"""Cosines between the chest's front and the vertical above which it lies, and below which it does not."""
NEAR = 0.3  # distance (m) from the surface beyond which a limb is not attracted


@dataclass(frozen=True, eq=False)
class Mattress:
    """The top of a bed or sofa in its own frame. heights (X, Z) metres, -9 where there is none; corner (2,) x and z."""

    heights: np.ndarray
    corner: np.ndarray

    @classmethod
    def of(cls, surface: np.ndarray, level: float) -> Mattress:
        """Return the top estimated from samples (N, 3) of a piece around its mattress' height, metres."""
        corner = surface[:, [0, 2]].min(0)
        shape = np.ceil(np.ptp(surface[:, [0, 2]], axis=0) / CELL).astype(int) + 1
        some = surface[(surface[:, 1] < level + TOP) & (surface[:, 1] > level - BELOW)]
        at = ((some[:, [0, 2]] - corner) / CELL).astype(int)
        heights = np.full(shape, -9.0)
        np.maximum.at(heights, (at[:, 0], at[:, 1]), some[:, 1])
        return cls(grey_closing(heights, 3), corner)

    def over(self, points: np.ndarray) -> np.ndarray:
        """Return the height, metres, of points (..., 3) over the top; large where there is none."""
        at = (points[..., [0, 2]] - self.corner) / CELL - 0.5
        flat = at.reshape(-1, 2).T
        nearest = map_coordinates(self.heights, flat, order=0, mode="constant", cval=-9.0)
        linear = map_coordinates(self.heights, flat, order=1, mode="constant", cval=-9.0)
        height = np.where(linear > nearest - 0.05, linear, nearest).reshape(points.shape[:-1])
        return np.where(height > -5.0, points[..., 1] - height, 9.0)


def settled(clip: Clip, busy: np.ndarray, top: Mattress, give: float, flat: bool = True) -> Clip:
    """Return the clip, in the piece's frame, with the body on the top in frames flagged busy (T,), sitting or lying.

    flat: whether chest and head are also lowered onto the top.
    """
    lying = smoothstep((_reclined(clip) - SITTING) / (FLAT - SITTING)) * busy
    lying = gaussian_filter1d(lying, EVEN, mode="nearest")
    rows = np.flatnonzero(busy)[::2]
    if not len(rows):
        return clip
    places, feet = posing.ankles(clip.root, clip.rotations)
    for _ in range(PASSES):
        clip = _raised(clip, rows, lying, top, give)
        clip = _feet_kept(clip, places, feet, lying, busy)
        if flat:
            clip = _pitched(clip, rows, lying, top, give)
        for side in ("left", "right"):
            clip = _foot_on(clip, rows, lying, top, give, side)
            clip = _arm_out(clip, rows, top, give, side)
    return replace(clip, rotations=rotation.continuous(clip.rotations))


def _facing_up(clip: Clip) -> tuple[np.ndarray, np.ndarray]:
    """Return the cosines (T,) between the vertical and the chest's front, and its left."""
    _, turned = skeleton.forward_kinematics(clip.root, clip.rotations, posing.REST)
    matrix = rotation.quaternion_to_matrix(turned[:, skeleton.INDEX["spine3"]])
    return matrix[..., 1, 2], matrix[..., 1, 0]


def _reclined(clip: Clip) -> np.ndarray:
    """Return the sine (T,) of the trunk's angle to the vertical: 1 supine or on a side, 0 upright or bent forward."""
    front, left = _facing_up(clip)
    return np.hypot(np.maximum(front, 0.0), left * (front > -0.4))


def _feet_kept(
    clip: Clip,
    places: dict[str, np.ndarray],
    feet: dict[str, np.ndarray],
    lying: np.ndarray,
    busy: np.ndarray,
) -> Clip:
    """Return the clip with feet at their places on the floor, while the body still sits on the edge."""
    now, _ = posing.ankles(clip.root, clip.rotations)
    stays = (busy * (1 - lying))[:, None]
    targets = {}
    for side, place in places.items():
        low = smoothstep((ON_FLOOR[1] - place[:, 1]) / (ON_FLOOR[1] - ON_FLOOR[0]))[:, None] * stays
        targets[side] = now[side] + low * (place - now[side])
    return replace(clip, rotations=posing.planted(clip.root, clip.rotations, targets, feet))


def _gap(clip: Clip, rows: np.ndarray, part: np.ndarray, top: Mattress, nearest: int = 6) -> np.ndarray:
    """Return the height (R,), metres, of a part of the skin over the top: mean of the nearest vertices; < 0 inside."""
    over = top.over(probes.skinned(clip.root[rows], clip.rotations[rows], part))
    return np.sort(over, 1)[:, :nearest].mean(1)


def _every(values: np.ndarray, rows: np.ndarray, count: int) -> np.ndarray:
    """Return values (R,) at some frames interpolated to all frames (T,); 0 before and after."""
    return np.interp(np.arange(count), rows, values, left=0.0, right=0.0)


def _raised(clip: Clip, rows: np.ndarray, lying: np.ndarray, top: Mattress, give: float) -> Clip:
    """Return the clip with the pelvis on the top while lying, and out of it otherwise."""
    gap = _gap(clip, rows, probes.named(*TRUNK), top)
    onto = np.where(gap < NEAR, -(gap + PRESSED + 0.4 * give), 0.0)
    share = lying[rows]
    out = np.maximum(-gap - give, 0.0)
    out = np.where(out < 0.25, out, 0.0)
    up = gaussian_filter1d(_every(share * onto + (1 - share) * out, rows, len(clip)), EVEN, mode="nearest")
    return replace(clip, root=clip.root + up[:, None] * [0.0, 1.0, 0.0])


def _pitched(clip: Clip, rows: np.ndarray, lying: np.ndarray, top: Mattress, give: float) -> Clip:
    """Return the clip with chest and head on their support: bent backward when supine, sideways on a side."""
    rotations = clip.rotations
    front, left = _facing_up(clip)
    for name, part, joints in (
        ("chest", probes.named("spine2", "spine3"), {"spine1": 0.5, "spine2": 0.5}),
        ("head", probes.named("head"), {"neck": 0.8, "head": 0.1}),
    ):
        gap = _gap(replace(clip, rotations=rotations), rows, part, top)
        down = np.where(np.abs(gap) < NEAR, gap + PRESSED + 0.4 * give, 0.0) * lying[rows]
        angle = np.clip(0.8 * down / LEVERS[name], -MOST[name], MOST[name])
        angle = gaussian_filter1d(_every(angle, rows, len(clip)), EVEN, mode="nearest")
        for joint, share in joints.items():
            rotations = posing.pitched(rotations, joint, -share * angle * np.maximum(front, 0.0))
            rotations = posing.bent_aside(rotations, joint, share * angle * left)
    return replace(clip, rotations=rotations)


def _foot_on(clip: Clip, rows: np.ndarray, lying: np.ndarray, top: Mattress, give: float, side: str) -> Clip:
    """Return the clip with a lying foot and calf on the top; a foot over the edge or in the air is only kept out."""
    part = probes.named(f"{side}_ankle", f"{side}_foot", f"{side}_knee")
    gap = _gap(clip, rows, part, top, 3)
    # On a side, the upper leg rests on the lower one.
    _, left = _facing_up(clip)
    upper = np.clip(left if side == "left" else -left, 0.0, 1.0)
    pulled = (lying * (1 - upper))[rows]
    far = np.where(np.abs(left[rows]) > ON_SIDE, 2.0, 1.0)
    up = np.where(gap < 0, -gap - 0.5 * give, -np.minimum(gap, 0.1 * far) * pulled**4)
    up = np.where(np.abs(gap) < 0.25 * far, up, 0.0)
    free = np.maximum(-gap - give, 0.0) * (np.abs(gap) < 0.25)
    up = gaussian_filter1d(_every(0.8 * up, rows, len(clip)), EVEN, mode="nearest")
    up = np.maximum(up, 0.9 * anticipate(_every(free, rows, len(clip)), 5, 2.0))
    if np.abs(up).max() < 1e-3:
        return clip
    places, feet = posing.ankles(clip.root, clip.rotations)
    target = places[side] + up[:, None] * [0.0, 1.0, 0.0]
    rotations = solve_limb(clip.root, clip.rotations, posing.REST, f"{side}_leg", target)
    return replace(clip, rotations=posing.end_turned(clip.root, rotations, f"{side}_ankle", feet[side]))


def _arm_out(clip: Clip, rows: np.ndarray, top: Mattress, give: float, side: str) -> Clip:
    """Return the clip with an arm out of the top: elbow first, then hand."""
    for upper, lower in (("shoulder", "elbow"), ("elbow", "wrist")):
        part = (
            probes.named(f"{side}_{upper}", f"{side}_{lower}") if upper == "shoulder" else probes.hand(side)
        )
        gap = _gap(clip, rows, part, top, 3)
        inside = np.where(gap > -0.2, np.maximum(-gap - give, 0.0), 0.0)
        if inside.max() < 2e-3:
            continue
        up = 1.1 * anticipate(_every(inside, rows, len(clip)), 7, 2.0)
        positions, turned = skeleton.forward_kinematics(clip.root, clip.rotations, posing.REST)
        a, b = skeleton.INDEX[f"{side}_{upper}"], skeleton.INDEX[f"{side}_{lower}"]
        bone = positions[:, b] - positions[:, a]
        about = rotation.between(bone, bone + up[:, None] * [0.0, 1.0, 0.0])
        rotations = clip.rotations.copy()
        parent = turned[:, skeleton.PARENTS[a]]
        rotations[:, a] = rotation.multiply(
            rotation.conjugate(parent), rotation.multiply(about, turned[:, a])
        )
        clip = replace(clip, rotations=rotations)
    return clip
