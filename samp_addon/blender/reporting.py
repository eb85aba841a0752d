"""What is reported of a job: plain JSON, in Blender's world and the scene's frames."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from .. import frames
from ..evaluation import metrics
from ..evaluation.obstacles import Obstacles
from ..job import Job
from ..refine.refining import Refined
from ..synthesis.chain import Clock, Take
from . import actions, character

SCHEMA_VERSION = 1


def report(variants: Sequence[dict] = (), errors: Sequence[dict] = ()) -> dict:
    """The report's outer form."""
    return {"schema_version": SCHEMA_VERSION, "variants": list(variants), "errors": list(errors)}


def entry(
    context: bpy.types.Context,
    job: Job,
    take: Take,
    action: bpy.types.Action,
    owner: bpy.types.Object,
    obstacles: Obstacles,
) -> dict:
    """The entry of one take: what the armature shows, in Blender's world. obstacles: of the job's last scene."""
    first, last = action.frame_range
    clock = Clock()
    clock.seconds.update(take.seconds)
    with clock.stage("measure"):
        shown = actions.read_motion(owner, action, scene=context.scene)
        floor = float(take.waypoints[:, 1].min())
        numbers = metrics.measure(shown, take.goal, obstacles, floor, character.body_of(owner))
    begun = shown.interaction_start
    told = {
        "seed": take.seed,
        "action": ",".join(step.action for step in job.steps),
        "target": ",".join(step.target for step in job.steps),
        "armature": owner.name,
        "action_name": action.name,
        "frame_start": int(first),
        "frame_end": int(last),
        "fps": actions.frames_per_second(context.scene),
        "goal_position": _rounded(frames.to_blender(take.goal.position)),
        "goal_direction": _rounded(frames.to_blender(take.goal.direction)),
        "waypoints": _rounded(frames.to_blender(take.waypoints)),
        "interaction_start": None if begun is None else int(first) + int(begun),
        "steps": _steps(job, take, int(first), (last - first) / max(len(take.motion) - 1, 1)),
        "attempts": take.attempts,
        "metrics": {name: _rounded(value) for name, value in numbers.items()},
        "seconds": {name: round(value, 3) for name, value in clock.seconds.items()},
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
