"""The ways of pelvis and feet as coloured lines: where feet stand, and where they slide. Network frame, metres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..motion import Motion, velocities
from ..refine.feet.foot import sole_points
from ..refine.feet.plan import plan_feet
from ..refine.proportions.footprints import Footprints

SLIDES = 0.15
"""Metres per second of a standing foot over the floor from which it slides."""

PELVIS, SWINGS, STANDS, RED = (
    (0.25, 0.55, 1.0, 0.9),
    (0.6, 0.6, 0.6, 0.5),
    (0.2, 0.8, 0.3, 1.0),
    (1.0, 0.15, 0.1, 1.0),
)
"""Colours of the pelvis' way, and of a foot's while it swings, stands and slides."""


@dataclass(frozen=True)
class Trails:
    """Lines. points: (N, 2, 3) their ends. colours: (N, 4) red, green, blue and alpha. stands: (M, 3) where feet stand.
    slides: (M,) whether they slide there."""

    points: np.ndarray
    colours: np.ndarray
    stands: np.ndarray
    slides: np.ndarray


def trails(motion: Motion) -> Trails:
    """Return the ways of pelvis and feet of a motion; a foot's is that of its ball."""
    if len(motion) < 2:
        return Trails(np.zeros((0, 2, 3)), np.zeros((0, 4)), np.zeros((0, 3)), np.zeros(0, bool))
    joints, globals_ = motion.forward_kinematics()
    points, colours = [_segments(motion.root)], [np.tile(PELVIS, (len(motion) - 1, 1))]
    stands, slides = [], []
    for plan in plan_feet(motion, Footprints.of(motion)):
        ball = joints[:, plan.foot.ball]
        # A foot that rolls over its heel or its ball does not slide.
        ends = sole_points(joints, globals_, motion.rest_joints, plan.foot.side)
        ways = [velocities(end, motion.fps)[:, [0, 2]] for end in ends]
        speed = np.min([np.linalg.norm(way, axis=-1) for way in ways], axis=0)
        sliding = plan.standing & (speed > SLIDES)
        colour = np.where(plan.standing[:, None], STANDS, SWINGS)
        points.append(_segments(ball))
        colours.append(np.where(sliding[:, None], RED, colour)[1:])
        for stance in plan.stances:
            part = slice(stance.first, stance.last)
            stands.append(ball[part].mean(0))
            slides.append(bool(sliding[part].mean() > 0.2))
    return Trails(
        np.concatenate(points),
        np.concatenate(colours),
        np.array(stands).reshape(-1, 3),
        np.array(slides, bool),
    )


def _segments(way: np.ndarray) -> np.ndarray:
    """Return the lines (T - 1, 2, 3) between points (T, 3)."""
    return np.stack([way[:-1], way[1:]], 1)
