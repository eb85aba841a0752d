"""Where the phases of a take begin, and where its feet come down. Network frame, metres."""

from __future__ import annotations

import numpy as np

from ..motion import Motion, velocities
from ..refine.feet.plan import plan_feet
from ..refine.proportions.footprints import Footprints
from ..refine.runs import runs
from ..vocabulary import ACTIONS, SEATED
from .retiming import SETTLED_SPEED

Mark = tuple[int, str]
"""A frame and what begins there."""

DOWN = {"sit": "Sit Down", "lie": "Lie Down"}
WALK, HOLD, UP = "Walk", "Hold", "Stand Up"


def phases(motion: Motion) -> list[Mark]:
    """Return where walking, sitting or lying down, the hold, and standing up begin."""
    found: list[Mark] = []
    speed = np.linalg.norm(velocities(motion.root, motion.fps), axis=-1)
    end = 0
    for first, last, kind in _rests(motion):
        if first > end:
            found.append((end, WALK))
        found.append((first, DOWN[kind]))
        calm = [run for run in runs(speed[first:last] < SETTLED_SPEED) if run[1] - run[0] >= motion.fps / 4]
        end = last
        if not calm:
            continue
        found.append((first + calm[0][0], HOLD))
        if last < len(motion):
            found.append((first + calm[-1][1], UP))
    if end < len(motion) - 1:
        found.append((end, WALK))
    return found


def steps(motion: Motion) -> list[Mark]:
    """Return where each foot comes down to stand."""
    plans = plan_feet(motion, Footprints.of(motion))
    named = [
        (stance.first, f"{plan.foot.side.capitalize()} Step") for plan in plans for stance in plan.stances
    ]
    return sorted(mark for mark in named if mark[0] > 0)


def _rests(motion: Motion) -> list[tuple[int, int, str]]:
    """Return first frame, frame after the last, and kind of each rest on furniture."""
    if motion.actions is None:
        start = motion.interaction_start
        return [] if start is None else [(start, len(motion), "sit")]
    kinds = motion.actions.argmax(-1)
    spans = [(first, last, kind) for kind in SEATED for first, last in runs(kinds == ACTIONS.index(kind))]
    return sorted(spans)
