"""From sitting on the edge of a bed to lying on it: partly captured, partly synthesised.

The captured clips have no bed. Captured are sitting down on the edge, and reclining from a seat on the floor, which is
raised to the mattress. The motion between them, swinging the legs up during a quarter turn, is synthesised here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ...samp_addon import rotation, skeleton
from ...samp_addon.body import human
from ...samp_addon.easing import smoothstep
from ...samp_addon.frames import wrap_angle
from ...samp_addon.motion import Motion
from ...samp_addon.refine.inverse_kinematics import solve_limb
from ..mocap.clip_files import Clip
from ..mocap.events import headings, turned, uprightness

# Captured reclines: from sitting on the floor, legs in front, to the end of lying still.
CAPTURED = {"111_12": (215, 403), "113_08": (88, 300)}
FLAT = 0.25  # cosine between chest and vertical below which a body lies
LEGS = [
    skeleton.INDEX[f"{side}_{name}"]
    for side in ("left", "right")
    for name in ("hip", "knee", "ankle", "foot")
]
LEGS_UNTIL, TURN_FROM = 0.65, 0.12  # shares of the swing at which the legs are up, and the turn begins
LEAN = np.radians(14.0)  # backward lean in the middle of the swing
SOFTEN = 2.0  # frames, sigma of the smoothing at both ends of the swing
CHEST_LEVER = 0.30  # metres from spine1 to the contact of the back
HEAD_LEVER = 0.20  # metres from the neck to the contact of the skull
SKULL_OVER = 0.07  # height (m) of the skull over the buttocks, since most mattresses have pillows
ANKLE_OVER = 0.075  # height (m) of an ankle over the mattress on which its heel rests


@dataclass(frozen=True)
class Recline:
    """A captured recline. clip: from the floor seat to lying still. still: index of the first frame of lying still."""

    clip: Clip
    still: int

    @property
    def height(self) -> float:
        """Height of the lying pelvis over its support, metres."""
        return float(np.median(self.clip.root[self.still :, 1]))


def reclines(clips: list[Clip]) -> list[Recline]:
    """Return the captured reclines among the clips and their mirror images."""
    found = []
    for clip in clips:
        span = CAPTURED.get(clip.name.removesuffix("_mirror"))
        if span is None:
            continue
        part = clip.cut(*span)
        still = int(np.flatnonzero(uprightness(part) > FLAT)[-1]) + 1
        found.append(Recline(flattened(part, still), still))
    return found


def flattened(clip: Clip, still: int) -> Clip:
    """Return the clip with the back as low as the buttocks while lying, and the skull slightly higher.

    The captured subjects lay on a hard floor, but retargeting and the neutral posture (posture.py) bend their trunks,
    so that the chest would be 4 cm deep in a mattress that touches the buttocks.
    """
    upright, reclined = np.cos(np.radians([25, 70]))
    weight = smoothstep((upright - uprightness(clip)) / (upright - reclined))
    for _ in range(6):
        low = _lowest(clip, still)
        chest_up = (low["pelvis"] - low["spine3"]) / CHEST_LEVER
        head_up = (low["pelvis"] + SKULL_OVER - low["head"]) / HEAD_LEVER
        clip = _pitched(clip, {"spine1": 0.5 * chest_up, "spine2": 0.5 * chest_up}, weight)
        clip = _pitched(clip, {"neck": 0.4 * head_up, "head": 0.2 * head_up}, weight)
    return clip


def _lowest(clip: Clip, still: int) -> dict[str, float]:
    """Return the height, metres, of the lowest skin of pelvis, chest and head while the body lies still."""
    body = human.load()
    motion = Motion(clip.root[still::10], clip.rotations[still::10])
    joints = np.take_along_axis(body.weight_joints, body.weights.argmax(1)[:, None], axis=1)[:, 0]
    heights = human.skin(body, motion, np.arange(len(body.vertices)))[..., 1].mean(0)
    return {name: float(heights[joints == skeleton.INDEX[name]].min())
            for name in ("pelvis", "spine3", "head")}  # fmt: skip


def _pitched(clip: Clip, angles: dict[str, float], weight: np.ndarray) -> Clip:
    """Return the clip with joints bent forward by angles in radians times weight (T,)."""
    rotations = clip.rotations.copy()
    for name, angle in angles.items():
        bend = rotation.from_axis_angle(weight[:, None] * np.array([np.clip(angle, -0.4, 0.4), 0.0, 0.0]))
        j = skeleton.INDEX[name]
        rotations[:, j] = rotation.multiply(rotations[:, j], bend)
    return replace(clip, rotations=rotations)


def laid(recline: Recline, position: np.ndarray, yaw: float) -> Clip:
    """Return the recline moved so that the lying pelvis is at position (3,) and the feet point along yaw, radians."""
    clip, hold = recline.clip, slice(recline.still, None)
    # For a supine body, the heading is the direction from head to feet.
    across = headings(clip.root, clip.rotations)[hold]
    turn = yaw - np.arctan2(np.sin(across).mean(), np.cos(across).mean())
    root, rotations = turned(clip.root, clip.rotations, turn, np.zeros(3))
    root = root + (position - np.median(root[hold], axis=0))
    return replace(clip, root=root, rotations=rotations, feet=np.zeros_like(clip.feet))


def swing(
    before: Clip, after: Clip, frames: int, mattress: float, edge: tuple[np.ndarray, np.ndarray, float]
) -> Clip:
    """Return ``frames`` frames between the last of ``before`` (on the edge) and the first of ``after`` (lying).

    mattress: its height, metres. edge: the lying pelvis (3,), the direction outwards over the edge (3,) and the
    distance to the edge, metres.
    """
    t = np.arange(1, frames + 1) / (frames + 1)
    legs, body = smoothstep(t / LEGS_UNTIL), smoothstep((t - TURN_FROM) / (1 - TURN_FROM))
    a, b = before.rotations[-1], after.rotations[0]
    yaw_a = headings(before.root[-1:], before.rotations[-1:])[0]
    turn = wrap_angle(headings(after.root[:1], after.rotations[:1])[0] - yaw_a)
    # The heading takes the shorter turn; the remainder of the pelvis' rotation is blended separately.
    level_a = rotation.multiply(rotation.about_y(-yaw_a), a[0])
    level_b = rotation.multiply(rotation.about_y(-yaw_a - turn), b[0])
    lean = np.sin(np.pi * t) * -LEAN / 2
    tilt = np.stack([np.cos(lean), np.sin(lean), np.zeros(frames), np.zeros(frames)], -1)
    pelvis = rotation.multiply(tilt, blend(level_a, level_b, body))
    rotations = np.stack([blend(a[j], b[j], legs if j in LEGS else body) for j in range(len(a))], axis=1)
    rotations[:, 0] = rotation.multiply(rotation.about_y(yaw_a + turn * body), pelvis)
    root = before.root[-1] + body[:, None] * (after.root[0] - before.root[-1])
    root[:, 1] += 0.03 * np.sin(np.pi * body)
    rotations = feet_over(root, rotations, mattress, edge)
    still = np.zeros(frames)
    return replace(
        before, name="swing", root=root, rotations=rotation.continuous(rotations),
        labels=np.array(["lie_down"] * frames), feet=np.column_stack([still, still]), bad=still.astype(bool),
    )  # fmt: skip


def feet_over(
    root: np.ndarray, rotations: np.ndarray, mattress: float, edge: tuple[np.ndarray, np.ndarray, float]
) -> np.ndarray:
    """Return rotations (T, 22, 4) with ankles raised out of the mattress where they are over it."""
    middle, out, distance = edge
    for side in ("left", "right"):
        positions, _ = skeleton.forward_kinematics(root, rotations, skeleton.default_rest_joints())
        ankle = positions[:, skeleton.INDEX[f"{side}_ankle"]]
        inside = np.clip((distance + 0.12 - (ankle - middle) @ out) / 0.12, 0, 1)
        lift = np.maximum(mattress + ANKLE_OVER - ankle[:, 1], 0) * smoothstep(inside)
        lift = gaussian_filter1d(lift, SOFTEN, mode="nearest")
        if lift.max() > 1e-3:
            target = ankle + lift[:, None] * np.array([0.0, 1.0, 0.0])
            rotations = solve_limb(root, rotations, skeleton.default_rest_joints(), f"{side}_leg", target)
    return rotations


def softened(clip: Clip, joins: list[int]) -> Clip:
    """Return the clip smoothed around the joins of synthesised and captured motion, frame indices."""
    weight = np.zeros(len(clip))
    for join in joins:
        weight = np.maximum(weight, smoothstep(1 - np.abs(np.arange(len(clip)) - join) / (4 * SOFTEN)))
    quats = rotation.continuous(clip.rotations)
    smooth = rotation.normalise(gaussian_filter1d(quats, SOFTEN, axis=0, mode="nearest"))
    root = gaussian_filter1d(clip.root, SOFTEN, axis=0, mode="nearest")
    return replace(
        clip,
        root=clip.root + weight[:, None] * (root - clip.root),
        rotations=rotation.normalise(quats + weight[:, None, None] * (smooth - quats)),
    )


def blend(a: np.ndarray, b: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Return quaternions (T, 4) interpolated from a (4,) to b (4,) by share (T,), along the shorter arc."""
    b = b if a @ b >= 0 else -b
    return rotation.slerp(np.broadcast_to(a, (len(share), 4)), np.broadcast_to(b, (len(share), 4)), share)
