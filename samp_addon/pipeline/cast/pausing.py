"""A wait on the way, as in front of a narrow door, in place of one at the start. Network frame, metres."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...frames import direction_yaw, ground_lengths
from ...methods.scene_view import SceneView
from ...methods.step import Step
from ...methods.take import Take
from .. import steps

WORTH = 2.0
"""Seconds of waiting from which on a member waits on its way."""

LEAST_WAY = 1.0
"""Metres that it goes at least before it waits."""

STOPPING = 1.5
"""Seconds that stopping and setting off again take, which are no part of the wait."""

SHORTEST = 0.4
"""Seconds for which a member stands at least."""

METHOD = "samp"

Pause = tuple[np.ndarray, float, float]
"""Place on the floor (3,), facing in radians, and seconds to stand there."""


def at(take: Take, frame: int, seconds: float) -> Pause | None:
    """Return the pause where a take is in a frame; None where it has hardly set off by then."""
    if ground_lengths(take.motion.root[: frame + 1])[-1] < LEAST_WAY:
        return None
    place = take.motion.root[frame].copy()
    place[1] = take.floor_start[1]
    yaw = float(direction_yaw(take.motion.headings()[frame]))
    return place, yaw, max(seconds - STOPPING, SHORTEST)


def step(pause: Pause, view: SceneView, step_after: Step) -> tuple[Step, SceneView]:
    """Return the step that goes to a pause and stands there. view, step_after: of what it goes on with."""
    place, yaw, seconds = pause
    going = Step(
        action="run" if step_after.action == "run" else "walk",
        method=METHOD,
        hold=seconds,
        style=step_after.style,
        speed=step_after.speed,
    )
    return going, replace(view, target=None, parts=(), destination=(place, yaw), goals=(), via=())


def merged(take: Take) -> Take:
    """Return a take that began with a pause, its first two steps as one."""
    if len(take.steps) <= 2:
        return replace(take, steps=())
    return replace(take, steps=(steps.joined(take.steps[:2]), *take.steps[2:]))
