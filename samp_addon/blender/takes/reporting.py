"""What is reported of a job: plain JSON, in Blender's world and the scene's frames."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np

from ... import frames
from ...body.human import Human
from ...evaluation import metrics
from ...evaluation.obstacles import Obstacles
from ...methods.take import Take
from ...motion import Motion
from ...pipeline.job import Job
from ...refine.refinement import Refined
from ..actions import keyframes

SCHEMA_VERSION = 1


def report(variants: Sequence[dict] = (), errors: Sequence[dict] = ()) -> dict:
    """The report's outer form."""
    return {"schema_version": SCHEMA_VERSION, "variants": list(variants), "errors": list(errors)}


@dataclass(frozen=True)
class Measured:
    """What an armature shows of a take: the frame in which it begins to sit or lie, the measures, and how many seconds
    they took."""

    begun: int | None
    numbers: dict
    seconds: float


def measured(shown: Motion, take: Take, obstacles: Obstacles, body: Human) -> Measured:
    """Measures a take as it is shown; needs no Blender. obstacles: of the job's last scene."""
    begun = time.perf_counter()
    floor = float(take.waypoints[:, 1].min())
    numbers = metrics.measure(shown, take.goal, obstacles, floor, body)
    rounded = {name: _rounded(value) for name, value in numbers.items()}
    return Measured(shown.interaction_start, rounded, time.perf_counter() - begun)


def entry(
    context: bpy.types.Context,
    job: Job,
    take: Take,
    action: bpy.types.Action,
    owner: bpy.types.Object,
    measured: Measured,
) -> dict:
    """The entry of one take: what the armature shows, in Blender's world."""
    first, last = action.frame_range
    begun, seconds = measured.begun, take.seconds | {"measure": measured.seconds}
    told = {
        "seed": take.seed,
        "action": ",".join(step.action for step in job.steps),
        "target": ",".join(step.target for step in job.steps),
        "armature": owner.name,
        "action_name": action.name,
        "frame_start": int(first),
        "frame_end": int(last),
        "fps": keyframes.frames_per_second(context.scene),
        "goal_position": _rounded(frames.to_blender(take.goal.position)),
        "goal_direction": _rounded(frames.to_blender(take.goal.direction)),
        "waypoints": _rounded(frames.to_blender(take.waypoints)),
        "interaction_start": None if begun is None else int(first) + int(begun),
        "steps": _steps(job, take, int(first), (last - first) / max(len(take.motion) - 1, 1)),
        "attempts": take.attempts,
        "metrics": measured.numbers,
        "seconds": {name: round(value, 3) for name, value in seconds.items()},
    }
    return told if take.refined is None else told | {"refined": _refined(take.refined)}


def _refined(refined: Refined) -> dict:
    """What a refinement changed, for the report."""
    sides = {"before": refined.before, "after": refined.after}
    told = {
        side: {name: _rounded(value) for name, value in numbers.items()} for side, numbers in sides.items()
    }
    return told | {"unsolved_cm": _rounded(refined.unsolved * 100)}


def _steps(job: Job, take: Take, first: int, scale: float) -> list[dict]:
    """What each step of a take is and where it ends, in the scene's frames; empty for a single action."""
    told, ends = [], np.cumsum([len(step.motion) for step in take.steps]) - 1
    for step, made, end in zip(job.steps, take.steps, ends, strict=False):
        told.append(
            {
                "action": step.action,
                "target": step.target,
                "frame_end": first + round(float(end) * scale),
                "goal_position": _rounded(frames.to_blender(made.goal.position)),
                "goal_direction": _rounded(frames.to_blender(made.goal.direction)),
            }
        )
    return told


def _rounded(value: object) -> object:
    """Plain JSON of numbers, six decimals."""
    if isinstance(value, bool) or value is None:
        return value
    return np.round(np.asarray(value, dtype=np.float64), 6).tolist()
