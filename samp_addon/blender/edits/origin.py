"""What a take was made of: its job, and where the artist's objects were, as a note of its Action.

With it the end of a take can be made again, and what has moved since is known.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from typing import Any

import bpy
import numpy as np

from ... import frames
from ...errors import SampError
from ...methods.step import Step
from ...methods.take import Take
from ...pipeline.job import Job
from ..overlays import goal_arrows

KEY = "samp_job"
STEP = ("action", "target", "point", "to", "method", "via", "settings")
SHARED = ("hold", "style", "speed", "refine", "seed")


@dataclass(frozen=True)
class Origin:
    """The job of one take.

    job: with the take's own seed. ends: last frame of each step, in the scene's frames. via: (N, 3) way-points that the
    first step passed. targets: for each step the matrix (4, 4) of its target, or None. arrows: for each step the
    matrices of the target's goal arrows by name. Places in Blender's world.
    """

    job: Job
    ends: tuple[int, ...]
    via: np.ndarray
    targets: tuple[np.ndarray | None, ...]
    arrows: tuple[dict[str, np.ndarray], ...]

    def step_at(self, frame: int) -> int:
        """Return the number of the step that a frame is in."""
        return min(sum(frame > end for end in self.ends), len(self.ends) - 1)

    def job_from(self, number: int, seed: int, character: str) -> Job:
        """Return the job of the steps from a number on, of a character and one take."""
        first, *then = self.job.steps[number:]
        own = {name: getattr(first, name) for name in STEP}
        return replace(self.job, **own, then=tuple(then), seed=seed, character=character)


def write(
    context: bpy.types.Context, action: bpy.types.Action, job: Job, take: Take, via: Any, frame_start: int
) -> None:
    """Note what a take was made of. via: places (3,) that its first step passed, network frame."""
    length = int(action.frame_range[1]) - frame_start
    ends = np.cumsum([len(step.motion) for step in take.steps] or [len(take.motion)]) - 1
    ends = frame_start + np.round(ends * length / max(ends[-1], 1)).astype(int)
    plain = replace(job, seed=take.seed, variants=1, start=None, shape={}, character="")
    store(action, Origin(plain, tuple(int(end) for end in ends), _world(via), *places(context, plain)))


def store(action: bpy.types.Action, origin: Origin) -> None:
    """Write the note."""
    steps = [{name: _plain(getattr(step, name)) for name in STEP} for step in origin.job.steps]
    text = {name: getattr(origin.job, name) for name in SHARED}
    text |= {
        "steps": steps,
        "ends": origin.ends,
        "via": _plain(origin.via),
        "targets": _plain(origin.targets),
    }
    action[KEY] = json.dumps(text | {"arrows": _plain(origin.arrows)})


def read(action: bpy.types.Action) -> Origin:
    """Return what a take was made of. Raise SampError where that is not known, or sub-goals say where it goes."""
    if KEY not in action:
        raise SampError(
            f"How '{action.name}' was made is not known; choose a generated take, not an edited copy."
        )
    stored = json.loads(action[KEY])
    steps = [Step(**{name: _tuples(value) for name, value in step.items()}) for step in stored["steps"]]
    if not all(step.action for step in steps):
        raise SampError(
            f"'{action.name}' has no action and target; only takes of an action can be made again."
        )
    first = {name: getattr(steps[0], name) for name in STEP}
    job = Job(**first, **{name: stored[name] for name in SHARED}, then=tuple(steps[1:]))
    matrix = lambda rows: None if rows is None else np.array(rows)
    return Origin(
        job,
        tuple(stored["ends"]),
        np.array(stored["via"], dtype=float).reshape(-1, 3),
        tuple(matrix(rows) for rows in stored["targets"]),
        tuple({name: np.array(rows) for name, rows in own.items()} for own in stored["arrows"]),
    )


def places(
    context: bpy.types.Context, job: Job
) -> tuple[tuple[np.ndarray | None, ...], tuple[dict[str, np.ndarray], ...]]:
    """Return where the targets of a job's steps and their goal arrows are now."""
    context.view_layer.update()
    objects = context.scene.objects
    found = [objects.get(step.target) if step.target else None for step in job.steps]
    targets = tuple(None if obj is None else np.array(obj.matrix_world) for obj in found)
    arrows = tuple(
        {
            arrow.name: np.array(arrow.matrix_world)
            for arrow in goal_arrows.arrows(context, step.target, step.action)
        }
        for step in job.steps
    )
    return targets, arrows


def _world(via: Any) -> np.ndarray:
    return np.array([frames.to_blender(np.asarray(place)) for place in via], dtype=float).reshape(-1, 3)


def _plain(value: Any) -> Any:
    """Return a value as JSON has it."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if hasattr(value, "items"):
        return {name: _plain(one) for name, one in value.items()}
    return [_plain(one) for one in value] if isinstance(value, list | tuple) else value


def _tuples(value: Any) -> Any:
    """Return a value from JSON with tuples in place of lists."""
    return tuple(_tuples(one) for one in value) if isinstance(value, list) else value
