"""Select captured locomotion that suits rooms: natural, forwards, on foot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import binary_dilation, uniform_filter1d

from ...samp_addon.frames import wrap_angle
from .clip_files import FPS, Clip
from .events import headings, label_runs, uprightness
from .posture import UPRIGHT

# Subjects of the CMU database with an acted style (drunk, gangly, heavy, sneaking), similar clips, and one whose knees
# are bent in every step by retargeting.
STYLED = ("17_", "39_", "132_", "137_", "142_", "139_", "14_01", "14_02", "14_03")
ASTRAY = np.radians(50)  # largest angle between velocity and facing
MOVING = 0.35  # speed (m/s) from which the angle is checked
SPELL = 8  # frames of the shortest run that is marked
BRISK = 0.85  # m/s, median of the frames labelled as walking
CROUCHED = 0.83  # height (m) of the pelvis over the floor below which a body bends down
BOWED = np.cos(np.radians(38.0))  # cosine between chest and vertical below which a body bows
BOW = 6  # frames before and after that are excluded too


def styled(clip: Clip) -> bool:
    """Return whether the clip has an acted style of walking."""
    return clip.name.startswith(STYLED)


def on_foot(clip: Clip) -> bool:
    """Return whether the clip contains no sitting or lying."""
    return not set(clip.labels) & {"sit", "lie", "sit_down", "lie_down", "get_up"}


def astray_marked(clip: Clip) -> Clip:
    """Return the clip with bad frames marked: steps backwards and sideways, bending, and the label "other"."""
    velocity = np.gradient(uniform_filter1d(clip.root[:, [0, 2]], 9, axis=0, mode="nearest"), 1 / FPS, axis=0)
    off = np.arctan2(velocity[:, 0], velocity[:, 1]) - headings(clip.root, clip.rotations)
    off = np.abs(wrap_angle(off))
    astray = (off > ASTRAY) & (np.linalg.norm(velocity, axis=-1) > MOVING)
    bad = clip.bad | (clip.labels == "other")
    for name, start, stop in label_runs(astray):
        if name == "True" and stop - start >= SPELL:
            bad[start:stop] = True
    return replace(clip, bad=bad | bending(clip))


def bending(clip: Clip) -> np.ndarray:
    """Flag frames (T,) in which a walking or standing body crouches or bows, to pick something up or to jump."""
    bends = np.isin(clip.labels, UPRIGHT) & ((clip.root[:, 1] < CROUCHED) | (uprightness(clip) < BOWED))
    return binary_dilation(bends, np.ones(2 * BOW + 1))


def pace(clip: Clip) -> float:
    """Return the median speed, m/s, of the frames labelled as walking; 0 without any."""
    speed = np.linalg.norm(np.gradient(clip.root[:, [0, 2]], 1 / FPS, axis=0), axis=-1)
    walking = clip.labels == "walk"
    return float(np.median(speed[walking])) if walking.any() else 0.0
