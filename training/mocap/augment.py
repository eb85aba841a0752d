"""Augment captured motion by other paces and paths, in addition to the other objects of the paper's section 4.2."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ...samp_addon import rotation
from ...samp_addon.motion import Motion
from ...samp_addon.refine.feet.foot_lock import LABELLED, lock_feet
from .clip_files import Clip

CHANGED = replace(LABELLED, steps=False)
"""Foot lock of clips whose way was changed: captured motion has steps already."""


def paced(clip: Clip, factor: float) -> Clip:
    """Return the clip ``factor`` times as fast, at the same frame rate. Raise ValueError unless factor > 0."""
    if factor <= 0:
        raise ValueError(f"the pace {factor} has to be positive")
    count = max(2, round((len(clip) - 1) / factor) + 1)
    at = np.linspace(0, len(clip) - 1, count)
    before = np.minimum(at.astype(int), len(clip) - 2)
    share = at - before
    nearest = np.round(at).astype(int)
    quats = rotation.continuous(clip.rotations)
    return replace(
        clip,
        root=clip.root[before] + share[:, None] * (clip.root[before + 1] - clip.root[before]),
        rotations=rotation.slerp(quats[before], quats[before + 1], share[:, None]),
        labels=clip.labels[nearest],
        feet=clip.feet[nearest],
        bad=clip.bad[nearest],
    )


def bent(clip: Clip, curvature: float) -> Clip:
    """Return the clip with its path bent to the left by ``curvature``, radians per metre walked."""
    steps = np.diff(gaussian_filter1d(clip.root[:, [0, 2]], 3, axis=0, mode="nearest"), axis=0)
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(steps, axis=-1))])
    turn = rotation.about_y(curvature * way)
    moved = np.diff(clip.root, axis=0)
    root = clip.root.copy()
    root[1:] = clip.root[0] + np.cumsum(rotation.rotate(turn[:-1], moved), axis=0)
    rotations = clip.rotations.copy()
    rotations[:, 0] = rotation.multiply(turn, rotations[:, 0])
    return replace(clip, root=root, rotations=rotations)


def relocked(clip: Clip) -> Clip:
    """Return the clip with its feet locked again after changes."""
    contacts = np.column_stack([np.zeros((len(clip), 3)), clip.feet])
    locked = lock_feet(Motion(clip.root, clip.rotations, contacts=contacts), settings=CHANGED)
    return replace(clip, root=locked.root, rotations=rotation.continuous(locked.rotations))
