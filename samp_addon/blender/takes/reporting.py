"""The report of a job: plain JSON, in Blender's world and the scene's frames."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np

from ... import frames
from ...body.human import Human
from ...evaluation import guards, metrics
from ...evaluation.obstacles import Obstacles
from ...methods.take import Take
from ...motion import Motion
from ...pipeline.job import Job
from ...refine.refinement import Refined
from ..actions import keyframes

SCHEMA_VERSION = 2


def report(variants: Sequence[dict] = (), errors: Sequence[dict] = ()) -> dict:
    """Return a whole report."""
    return {"schema_version": SCHEMA_VERSION, "variants": list(variants), "errors": list(errors)}


@dataclass(frozen=True)
class Measured:
    """The measures of a take as an armature shows it.

    begun: frame index in which the character begins to sit or lie, or None. numbers: evaluation.metrics.measure.
    seconds: how long that took. warnings: what is wrong with the take, in sentences.
    """

    begun: int | None
    numbers: dict
    seconds: float
    warnings: tuple[str, ...] = ()


def measured(shown: Motion, take: Take, obstacles: Obstacles, body: Human) -> Measured:
    """Measure a take as it is shown; needs no Blender. obstacles: of the job's scene."""
    begun = time.perf_counter()
    numbers = metrics.measure(shown, take.goal, obstacles, take.floor, body)
    rounded = {name: _rounded(value) for name, value in numbers.items()}
    warnings = (*take.remarks, *guards.warnings(numbers))
    return Measured(shown.interaction_start, rounded, time.perf_counter() - begun, warnings)


def entry(
    context: bpy.types.Context,
    job: Job,
    take: Take,
    action: bpy.types.Action,
    owner: bpy.types.Object,
    measured: Measured,
) -> dict:
    """Return the report's entry of one take: what the armature shows, in Blender's world; None where the method does
    not know something."""
    first, last = action.frame_range
    scale = (last - first) / max(len(take.motion) - 1, 1)
    frame = lambda number: None if number is None else int(first) + int(number)
    seconds = take.seconds | {"measure": measured.seconds}
    return {
        "seed": take.seed,
        "method": ",".join(dict.fromkeys(step.method for step in job.steps)),
        "action": ",".join(step.action for step in job.steps) or None,
        "target": ",".join(step.target for step in job.steps) or None,
        "armature": owner.name,
        "shape": dict(job.shape) or None,
        "action_name": action.name,
        "frame_start": int(first),
        "frame_end": int(last),
        "fps": keyframes.frames_per_second(context.scene),
        **_goal(take),
        "waypoints": None if take.waypoints is None else _rounded(frames.to_blender(take.waypoints)),
        "interaction_start": frame(measured.begun),
        "sub_goals": _sub_goals(take, int(first), scale),
        "camera": take.camera,
        "cast": [],
        "steps": _steps(job, take, int(first), scale),
        "attempts": take.attempts,
        "metrics": measured.numbers,
        "warnings": list(measured.warnings),
        "seconds": {name: round(value, 3) for name, value in seconds.items()},
    } | ({} if take.refined is None else {"refined": _refined(take.refined)})


def _goal(take: Take) -> dict:
    goal = take.goal
    return {
        "goal_position": None if goal is None else _rounded(frames.to_blender(goal.position)),
        "goal_direction": None if goal is None else _rounded(frames.to_blender(goal.direction)),
    }


def _sub_goals(take: Take, first: int, scale: float) -> list[dict] | None:
    """Return the places that a take passes, in the scene's frames; None where its method has none."""
    if take.sub_goals is None:
        return None
    return [
        {
            "position": _rounded(frames.to_blender(place.position)),
            "direction": _rounded(frames.to_blender(place.direction)),
            "frame": first + round(place.frame * scale),
        }
        for place in take.sub_goals
    ]


def _refined(refined: Refined) -> dict:
    """Return what a refinement changed."""
    sides = {"before": refined.before, "after": refined.after}
    found = {
        side: {name: _rounded(value) for name, value in numbers.items()} for side, numbers in sides.items()
    }
    return found | {"unsolved_cm": _rounded(refined.unsolved * 100)}


def _steps(job: Job, take: Take, first: int, scale: float) -> list[dict]:
    """Return each step of a take and where it ends, in the scene's frames; empty for a single action."""
    ends = np.cumsum([len(step.motion) for step in take.steps]) - 1
    return [
        {
            "method": made.method,
            "action": step.action,
            "target": step.target,
            "frame_end": first + round(float(end) * scale),
            **_goal(made),
        }
        for step, made, end in zip(job.steps, take.steps, ends, strict=False)
    ]


def _rounded(value: object) -> object:
    """Return numbers as plain JSON, with six decimals."""
    if isinstance(value, bool) or value is None:
        return value
    return np.round(np.asarray(value, dtype=np.float64), 6).tolist()
