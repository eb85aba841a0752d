"""Long approaches: captured walks joined to the entry of a sit where poses and velocities match."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from ...samp_addon import rotation, skeleton
from ...samp_addon.easing import smoothstep
from ..mocap.clip_files import FPS, Clip
from ..mocap.events import headings, turned

FADE = 12  # frames over which the offset at the join decays (inertial blending)
_WATCHED = [skeleton.INDEX[n] for n in ("left_foot", "right_foot", "left_ankle", "right_ankle", "left_wrist",
                                        "right_wrist", "head", "pelvis")]  # fmt: skip


def pose_features(root: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    """Return features (T, 48): positions and velocities (weighted by 0.15 s) of eight joints in the root frame."""
    positions, _ = skeleton.forward_kinematics(root, rotations, skeleton.default_rest_joints())
    yaw = headings(root, rotations)
    back = np.broadcast_to(rotation.about_y(-yaw)[:, None], (len(root), len(_WATCHED), 4))
    velocity = np.gradient(positions, 1 / FPS, axis=0)[:, _WATCHED]
    local = positions[:, _WATCHED] - root[:, None] * np.array([1.0, 0.0, 1.0])
    return np.concatenate([rotation.rotate(back, local), 0.15 * rotation.rotate(back, velocity)], -1).reshape(
        len(root), -1
    )


class WalkIndex:
    """Nearest-neighbour search over all frames of walking that follow ``history`` frames of their clip."""

    def __init__(self, clips: list[Clip], history: int = 20, stride: int = 2) -> None:
        self.clips = clips
        features, self.where = [], []
        for number, clip in enumerate(clips):
            if len(clip) < history + 10:
                continue
            usable = np.isin(clip.labels, ("walk", "shift")) & ~clip.bad
            usable[:history] = False
            frames = np.flatnonzero(usable)[::stride]
            features.append(pose_features(clip.root, clip.rotations)[frames])
            self.where += [(number, int(frame)) for frame in frames]
        self.tree = cKDTree(np.concatenate(features))

    def matches(self, feature: np.ndarray, count: int, farthest: float) -> list[tuple[int, int]]:
        """Return up to count (clip, frame) pairs whose features are within ``farthest`` of ``feature`` (48,)."""
        distance, index = self.tree.query(feature, k=count)
        return [self.where[i] for d, i in zip(distance, index, strict=True) if d < farthest]


def clean_start(clip: Clip, frame: int, longest: int) -> int:
    """Return the first frame of the clean run of at most ``longest`` frames that ends at ``frame``."""
    start = max(0, frame - longest)
    spoilt = np.flatnonzero(
        clip.bad[start : frame + 1] | np.isin(clip.labels[start : frame + 1], ("sit", "lie"))
    )
    return start + (int(spoilt[-1]) + 1 if len(spoilt) else 0)


def join(before: Clip, after: Clip) -> Clip:
    """Join two clips: ``before`` is moved to lead into ``after``, which stays in place, and the offset fades out.

    The last frame of before and the first of after are the same instant.
    """
    turn = (
        headings(after.root[:1], after.rotations[:1])[0]
        - headings(before.root[-1:], before.rotations[-1:])[0]
    )
    root, rotations = turned(before.root, before.rotations, turn, np.zeros(3))
    root = root + (after.root[0] - root[-1]) * np.array([1.0, 0.0, 1.0])
    weight = smoothstep(1 - np.arange(len(after)) / FADE)
    offset = rotation.multiply(rotations[-1], rotation.conjugate(after.rotations[0]))
    offset = np.where(offset[:, :1] < 0, -offset, offset)
    identity = np.array([1.0, 0.0, 0.0, 0.0])
    fading = rotation.slerp(np.broadcast_to(identity, after.rotations.shape), offset[None], weight[:, None])
    blended = rotation.multiply(fading, after.rotations)
    blended_root = after.root + weight[:, None] * (root[-1] - after.root[0]) * np.array([0.0, 1.0, 0.0])
    cat = lambda a, b: np.concatenate([a[:-1], b])
    return replace(
        after,
        name=f"{before.name}+{after.name}",
        root=cat(root, blended_root),
        rotations=rotation.continuous(cat(rotations, blended)),
        labels=cat(before.labels, after.labels),
        feet=cat(before.feet, after.feet),
        bad=cat(before.bad, after.bad),
    )
