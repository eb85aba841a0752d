"""Corrections of windows in which a body sits down, rests or rises. Network frame, metres.

RouteNet lowers the pelvis on a straight line, so that the body squats in the air on its way. Its training clips contain
drops onto seats at 1.5 m/s, so that the pelvis is too fast over the seat. The feet of PoseNet go on below the pelvis,
into the seat.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from ... import rotation
from ...motion import Motion, velocities
from ...refine.feet.corrections import Correction, apply, spread
from ...refine.feet.foot import FEET
from ...refine.feet.stances import Stance
from ...skeleton import INDEX
from ...vocabulary import SEATED

AWAY = (0.08, 0.11, 0.13, 0.15, 0.17, 0.19, 0.21, 0.24, 0.29, 0.35)
"""Horizontal distances of the pelvis from its seated place, metres, at 0, 10, ... and 90 % of the way up from its
seated to its standing height: the upper quartiles of 406 captured sits."""
PLANTED = (0.60, 0.45)
"""Horizontal distances of the pelvis from the seated place, metres, within which the first and the second foot stand
where they stand while the body sits."""
STEP = 9
"""Frames of the step of a foot to that place."""
HANGS = 0.08
"""Metres over the lowest place of a foot from which it hangs when the body sits."""
HUNG = (0.45, 0.17)
"""Horizontal distances of the pelvis from its seated place, metres, between which hanging feet rise: with legs that
still stand when the pelvis is over the front edge of a bar stool, the edge is in the thighs."""
STIR = 0.25
"""Share of the motion of pelvis and legs that a resting body keeps; more would move them into the seat."""
STILLED = ("pelvis", *(f"{side}_{part}" for side in ("left", "right") for part in ("hip", "knee", "ankle")))
SOFT = 2.0
"""Frames over which raised heights are smoothed."""
FASTEST = {"sit": 0.53, "lie": 0.47}
"""Metres per second of the pelvis near its rest: about the median of captured bodies that rise (0.47 within 3 cm of
it)."""
SLOW = {"sit": (0.3, 0.75), "lie": (0.6, 0.9)}
"""Shares of the standing height over the rest up to which FASTEST holds in full, and from which it does not hold. A
body that sits down as slowly from higher up squats in the air for more than a second."""
LONGEST = 14
"""Frames at 30 fps in which a body gets from bent knees to its seat, or back, at most; captured: 13 and 12 (median), 16
and 15 (75 % of 1,386 and 1,420)."""
OVER_REST, BENT = 0.08, 0.76
"""Metres over its rest from which a pelvis is not carried, and share of the standing height over the rest below which
both knees are bent."""
SPREAD = 7
"""Width, in frames, of the window around a fast frame that is slowed with it."""
SIGMA = 3.0
"""Frames, sigma of the Gaussian over which the pace changes."""


def raised(places: np.ndarray, sits: tuple[bool, bool]) -> np.ndarray:
    """Return the heights (T,) of a pelvis at places (T, 3), raised so that it is low only over its seat.

    sits: whether the body sits at the beginning and at the end.
    """
    heights = places[:, 1]
    if sits[0] == sits[1]:
        return heights
    rest, stands = (0, -1) if sits[0] else (-1, 0)
    away = np.linalg.norm((places - places[rest])[:, [0, 2]], axis=-1)
    share = np.interp(away, AWAY, np.linspace(0.0, 0.9, len(AWAY)))
    least = heights[rest] + share * (heights[stands] - heights[rest])
    return heights + _lift(heights, least)


def planted(motion: Motion, begin: str, end: str) -> Motion:
    """Return a window in which the feet of a body that sits down or rises stand where they stand while it sits.

    The feet step to these places one after the other, the nearer one first, before the pelvis is over the seat.
    begin, end: actions at the ends of the window.
    """
    if (begin == "sit") == (end == "sit"):
        return motion
    if begin == "sit":  # rising is sitting down backwards
        return backwards(planted(backwards(motion), end, begin))
    count, joints = len(motion), motion.forward_kinematics()[0]
    away = np.linalg.norm((motion.root - motion.root[-1])[:, [0, 2]], axis=-1)
    firsts = [int(np.flatnonzero(away > limit)[-1]) + 1 if (away > limit).any() else 0 for limit in PLANTED]
    firsts[0] = max(firsts[0], STEP)
    firsts[1] = max(firsts[1], firsts[0] + STEP)
    if firsts[1] >= count - 1:
        return motion
    left = [np.linalg.norm((joints[firsts[0], foot.ball] - joints[-1, foot.ball])[[0, 2]]) for foot in FEET]
    made = []
    for foot, first in zip(sorted(FEET, key=lambda foot: left[FEET.index(foot)]), firsts, strict=True):
        offset, standing = np.zeros((count, 3)), np.arange(count) >= first
        offset[first:, [0, 2]] = (joints[-1, foot.ball] - joints[first:, foot.ball])[:, [0, 2]]
        offset = spread(offset, [Stance(first, count)], STEP - 1)
        offset[:, 1] = _hung(joints[:, foot.ball, 1], away)
        made.append(Correction(foot, offset, standing))
    return apply(motion, made, lambda tips: np.full(count, -np.inf), 0.0)


def _hung(heights: np.ndarray, away: np.ndarray) -> np.ndarray:
    """Return by how much a foot rises (T,) that hangs while the body sits on a high seat: as the pelvis gets over it.

    heights: (T,) of its ball. away: (T,) horizontal distances of the pelvis from its seated place. All in metres.
    """
    hangs = heights[-1] - heights.min()
    if hangs < HANGS:
        return np.zeros_like(heights)
    least = heights.min() + hangs * np.clip((HUNG[0] - away) / (HUNG[0] - HUNG[1]), 0, 1)
    return _lift(heights, least)


def _lift(heights: np.ndarray, least: np.ndarray) -> np.ndarray:
    """Return the smooth lift (T,) of heights (T,) that are lower than ``least`` (T,); both ends stay where they are."""
    lift = gaussian_filter1d(np.maximum(least - heights, 0.0), SOFT, mode="nearest")
    lift[[0, -1]] = 0.0
    return lift


def backwards(motion: Motion) -> Motion:
    """Return a motion backwards in time."""
    return replace(motion, root=motion.root[::-1], rotations=motion.rotations[::-1])


def stilled(motion: Motion) -> Motion:
    """Return a window in which the pelvis and the legs of a resting body keep a share STIR of their motion."""
    joints = [INDEX[name] for name in STILLED]
    rotations = motion.rotations.copy()
    begin = np.broadcast_to(rotations[:1, joints], rotations[:, joints].shape)
    rotations[:, joints] = rotation.slerp(begin, rotations[:, joints], np.full((len(motion), 1), STIR))
    return replace(motion, root=motion.root[:1] + STIR * (motion.root - motion.root[:1]), rotations=rotations)


def hastened(motion: Motion, begin: str, end: str) -> Motion:
    """Return a window in which the body is between standing and its seat for LONGEST frames at most.

    The lengths of windows follow from distances, so that a body that comes from far sits down slowly, and squats in the
    air. begin, end: actions at the ends of the window.
    """
    if (begin == "sit") == (end == "sit") or "lie" in (begin, end) or len(motion) < 3:
        return motion
    height = motion.root[:, 1]
    rest, stands = (height[0], height[-1]) if begin == "sit" else (height[-1], height[0])
    between = (height > rest + OVER_REST) & (height < rest + BENT * (stands - rest))
    pace = np.where(between, min(LONGEST / max(between.sum(), 1), 1.0), 1.0)
    pace = gaussian_filter1d(pace, SIGMA, mode="nearest")
    return _at_pace(motion, pace)


def paced(motion: Motion, begin: str, end: str) -> Motion:
    """Return a window that takes longer where the pelvis is too fast for a body that sits or lies down, or rises.

    begin, end: actions at the ends of the window.
    """
    if not {begin, end} & set(SEATED) or len(motion) < 3:
        return motion
    action = "lie" if "lie" in (begin, end) else "sit"
    near, free = SLOW[action]
    height = motion.root[:, 1]
    over = (height - height.min()) / max(np.ptp(height), 1e-6)
    slow = np.clip((free - over) / (free - near), 0, 1)
    speed = np.linalg.norm(velocities(motion.root, motion.fps), axis=-1)
    slower = 1 + slow * (np.maximum(speed / FASTEST[action], 1) - 1)
    slower = gaussian_filter1d(maximum_filter1d(slower, SPREAD, mode="nearest"), SIGMA, mode="nearest")
    return _at_pace(motion, slower)


def _at_pace(motion: Motion, pace: np.ndarray) -> Motion:
    """Return a motion whose frames take pace (T,) times as long."""
    times = np.concatenate([[0.0], np.cumsum((pace[1:] + pace[:-1]) / 2)])
    count = int(np.ceil(times[-1] - 1e-9)) + 1
    if count == len(motion):
        return motion
    return motion.at_frames(np.interp(np.linspace(0, times[-1], count), times, np.arange(len(motion))))
