"""Find the sits in a clip from its labels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...samp_addon import rotation, skeleton
from .clip_files import Clip

# Sits on the floor and climbing, without a seat.
NOT_ON_A_SEAT = ("75_20", "114_16", "40_06")


@dataclass(frozen=True)
class SitEvent:
    """Frames of one sit in a clip: entry <= down < seated <= seat_end <= up_end <= leave_end.

    entry: first frame of the approach. down: first of sitting down. seated: first seated. seat_end: last seated.
    up_end: last frame of standing up, equal to seat_end where the clip ends seated. leave_end: last frame before the
    next sit. pelvis: (3,) mean pelvis while seated; yaw: heading there, radians.
    """

    clip: Clip
    entry: int
    down: int
    seated: int
    seat_end: int
    up_end: int
    leave_end: int
    pelvis: np.ndarray
    yaw: float


def label_runs(labels: np.ndarray) -> list[tuple[str, int, int]]:
    """Return (label, first, last + 1) of each run of equal labels."""
    cuts = np.concatenate([[0], np.flatnonzero(labels[1:] != labels[:-1]) + 1, [len(labels)]])
    return [(str(labels[a]), int(a), int(b)) for a, b in zip(cuts[:-1], cuts[1:], strict=True)]


def headings(root: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    """Return the yaw (T,) of the body's heading, radians, as defined by models/state.py."""
    positions, _ = skeleton.forward_kinematics(root, rotations, skeleton.default_rest_joints())
    across = positions[:, 1] - positions[:, 2] + positions[:, 16] - positions[:, 17]
    return np.arctan2(-across[:, 2], across[:, 0])


def uprightness(clip: Clip, joint: str = "spine3") -> np.ndarray:
    """Return the cosine (T,) between a joint's own vertical axis, by default the chest's, and the world's."""
    _, turned = skeleton.forward_kinematics(clip.root, clip.rotations, skeleton.default_rest_joints())
    return rotation.quaternion_to_matrix(turned[:, skeleton.INDEX[joint]])[..., 1, 1]


def sit_events(clip: Clip) -> list[SitEvent]:
    """Return all sits of a clip that begin with sitting down."""
    if clip.name.removesuffix("_mirror") in NOT_ON_A_SEAT:
        return []
    runs = label_runs(clip.labels)
    seats = [k for k, (label, _, _) in enumerate(runs) if label == "sit"]
    yaw = headings(clip.root, clip.rotations)
    events, free = [], 0
    for n, k in enumerate(seats):
        _, seated, end = runs[k]
        down = runs[k - 1][1] if k and runs[k - 1][0] == "sit_down" else None
        stands = k + 1 < len(runs) and runs[k + 1][0] == "stand_up"
        up_end = runs[k + 1][2] - 1 if stands else end - 1
        following = runs[seats[n + 1]][1] if n + 1 < len(seats) else len(clip)
        before_next = [a for label, a, _ in runs if label == "sit_down" and up_end < a <= following]
        leave_end = (before_next[0] if before_next else following) - 1
        if down is not None and end - seated >= 15:
            middle = slice(seated + 5, max(end - 5, seated + 6))
            facing = np.arctan2(np.sin(yaw[middle]).mean(), np.cos(yaw[middle]).mean())
            pelvis = np.median(clip.root[middle], axis=0)
            events.append(
                SitEvent(clip, free, down, seated, end - 1, up_end, leave_end, pelvis, float(facing))
            )
        free = up_end + 1
    return events


def turned(
    root: np.ndarray, rotations: np.ndarray, yaw: float, shift: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return a motion turned about the world's vertical axis by yaw, radians, and then moved by shift (3,), metres."""
    q = rotation.about_y(yaw)
    rotations = rotations.copy()
    rotations[:, 0] = rotation.multiply(np.broadcast_to(q, rotations[:, 0].shape), rotations[:, 0])
    return rotation.rotate(np.broadcast_to(q, (len(root), 4)), root) + shift, rotations
