"""Time before and after a take: a body that waits stands idly, one that is done keeps its last pose alive."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ... import skeleton
from ...methods.appending import append
from ...methods.method import Method
from ...methods.scene_view import SceneView
from ...methods.step import Step
from ...methods.take import SubGoal, Take
from ...motion import Motion
from ...progress import Progress
from . import together

SHORTEST = 0.05
"""Seconds below which nothing is put before a take."""

SWAY = 1.5
"""Longest part of a take's end, in seconds, that is played back and forth to hold its last pose longer."""

STILL = 0.04
"""Metres within which pelvis and feet stay in this part, so that a walk that has just ended is not played backwards."""

HELD = [skeleton.INDEX[name] for name in ("pelvis", "left_foot", "right_foot")]

IDLE = "samp"
"""The method whose idle action fills the time in which a body waits."""


def waiting(
    takes: Mapping[int, Take],
    seconds: Mapping[int, float],
    views: Mapping[int, SceneView],
    seeds: Mapping[int, int],
    methods: Mapping[str, Method],
    progress: Progress,
) -> dict[int, Take]:
    """Return the takes, each with an idle beginning of so many seconds; by member. views: of their first steps.

    Where the idle action cannot be made, the body stands still in the first pose.
    """
    late = [number for number in takes if seconds.get(number, 0.0) > SHORTEST]
    rows = {number: [idle_step(views[number], takes[number], seconds[number])] for number in late}
    made = together.generate(rows, seeds, methods, progress)[0] if IDLE in methods else {}
    return {
        number: after_waiting(take, made[number].motion if number in made else None, seconds[number])
        if number in late
        else take
        for number, take in takes.items()
    }


def idle_step(view: SceneView, take: Take, seconds: float) -> tuple[Step, SceneView]:
    """Return the step, with its view, in which a body stands idly where a take begins. view: of the take."""
    place, yaw = take.floor_start, float(np.arctan2(*take.motion.headings()[0][[0, 2]]))
    alone = replace(
        view,
        target=None,
        parts=(),
        start=(place, yaw),
        destination=None,
        goals=(),
        via=(),
        occupied=(),
        after={},
    )
    return Step(action="idle", hold=seconds, method=IDLE), alone


def after_waiting(take: Take, idle: Motion | None, seconds: float) -> Take:
    """Return a take that begins with so many seconds of an idle motion, or of its first pose."""
    motion = take.motion
    count = round(seconds * motion.fps)
    rows = np.zeros(count, dtype=int)
    before = motion.picked(rows)
    if idle is not None:
        idle = _matched(idle, motion)
        before = idle.picked(np.minimum(np.arange(count), len(idle) - 1))
    later = [replace(goal, frame=goal.frame + count) for goal in take.sub_goals or ()]
    own_steps = take.steps
    if own_steps:
        first = replace(own_steps[0], motion=append(before, own_steps[0].motion))
        own_steps = (first, *own_steps[1:])
    return replace(
        take,
        motion=append(before, motion),
        sub_goals=tuple(SubGoal(g.position, g.direction, g.frame) for g in later) or take.sub_goals,
        steps=own_steps,
    )


def lengthened(take: Take, frames: int) -> Take:
    """Return a take of at least so many frames, whose last seconds, up to SWAY, are played back and forth."""
    motion = take.motion
    missing = frames - len(motion)
    if missing <= 0:
        return take
    period = _still(motion)
    # 0, 1, ... period, ... 1, 0, 1, ... frames before the end.
    phase = np.arange(1, missing + 1) % (2 * period)
    back = np.where(phase <= period, phase, 2 * period - phase)
    rows = np.concatenate([np.arange(len(motion)), len(motion) - 1 - back])
    longer = replace(motion.picked(rows), interaction_start=motion.interaction_start)
    own_steps = take.steps
    if own_steps:
        last = own_steps[-1]
        tail = motion.picked(rows[len(motion) :])
        own_steps = (*own_steps[:-1], replace(last, motion=_joined(last.motion, tail)))
    return replace(take, motion=longer, steps=own_steps)


def _still(motion: Motion) -> int:
    """Return the number of frames before the last one in which pelvis and feet are within STILL of where they end.

    At least 1, and at most SWAY seconds.
    """
    longest = min(round(SWAY * motion.fps), len(motion) - 1)
    end = motion.picked(np.arange(len(motion) - 1 - longest, len(motion)))
    places = end.forward_kinematics()[0][:, HELD]
    moved = np.linalg.norm(places - places[-1], axis=-1).max(axis=-1)[::-1] > STILL
    return max(1, int(moved.argmax()) - 1 if moved.any() else longest)


def _joined(first: Motion, second: Motion) -> Motion:
    both = lambda a, b: None if a is None or b is None else np.concatenate([a, b])
    return replace(
        first,
        root=both(first.root, second.root),
        rotations=both(first.rotations, second.rotations),
        contacts=both(first.contacts, second.contacts),
        actions=both(first.actions, second.actions),
    )


def _matched(idle: Motion, motion: Motion) -> Motion:
    """Return an idle motion with as many joints as the other one."""
    count = motion.rotations.shape[1]
    if idle.rotations.shape[1] >= count:
        return replace(idle, rotations=idle.rotations[:, :count])
    rest = np.repeat(motion.rotations[:1, idle.rotations.shape[1] :], len(idle), axis=0)
    return replace(idle, rotations=np.concatenate([idle.rotations, rest], axis=1))
