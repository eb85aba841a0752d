"""Which captured locomotion is worth learning for a room: natural, forwards, on the feet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import binary_dilation, uniform_filter1d

from ...samp_addon.frames import wrap_angle
from .clip_files import FPS, Clip
from .events import headings, label_runs, uprightness
from .posture import UPRIGHT

# Subjects of the CMU database who act a style (drunk, gangly, heavy, sneaking), clips of the same kind, and one whose
# knees the retargeting bends in every step.
STYLED = ("17_", "39_", "132_", "137_", "142_", "139_", "14_01", "14_02", "14_03")
ASTRAY = np.radians(50)  # between the way that a body goes and the way that it faces
MOVING = 0.35  # m/s
SPELL = 8  # frames
BRISK = 0.85  # m/s, median of the frames labelled as walking
CROUCHED = 0.83  # metres of the pelvis over the floor: lower ones bend down for something
BOWED = np.cos(np.radians(38.0))  # between the chest and the vertical
BOW = 6  # frames before and after that are not learnt either


def styled(clip: Clip) -> bool:
    """Whether the clip's way of walking is an acted one."""
    return clip.name.startswith(STYLED)


def on_foot(clip: Clip) -> bool:
    """Whether nobody sits or lies in the clip."""
    return not set(clip.labels) & {"sit", "lie", "sit_down", "lie_down", "get_up"}


def astray_marked(clip: Clip) -> Clip:
    """The clip with its steps backwards and sideways, and all that is neither walking nor standing, marked bad."""
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
    """Flags (T,) of frames in which somebody who walks or stands crouches or bows, to pick something up or to jump."""
    bends = np.isin(clip.labels, UPRIGHT) & ((clip.root[:, 1] < CROUCHED) | (uprightness(clip) < BOWED))
    return binary_dilation(bends, np.ones(2 * BOW + 1))


def pace(clip: Clip) -> float:
    """Median speed in m/s of the frames labelled as walking; 0 without any."""
    speed = np.linalg.norm(np.gradient(clip.root[:, [0, 2]], 1 / FPS, axis=0), axis=-1)
    walking = clip.labels == "walk"
    return float(np.median(speed[walking])) if walking.any() else 0.0
