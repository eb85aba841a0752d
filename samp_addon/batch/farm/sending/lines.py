"""Jobs as lines of a jobs file: what jobs_file.py and order.py read back as the same job."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ....errors import SampError
from ....methods.step import Step
from ....pipeline.cast.cast import Cast, Member
from ....pipeline.job import Job
from ... import jobs_file
from ...order import order

_SHARED = ("hold", "style", "speed", "refine")


def line(job: Job | Cast, files: Mapping[str, str]) -> str:
    """Return the line of a job. files: the options of a line that name files, such as scene and npz.

    Raise SampError for a job that the options of a line cannot express: what is read back is compared with it.
    """
    values = _of_cast(job) if isinstance(job, Cast) else _of_job(job)
    text = json.dumps({**files, **values})
    if order(jobs_file.options(text, {})).job != job:
        raise SampError("A line of a jobs file cannot hold this job; bake it here, or send simpler steps.")
    return text


def pieces(job: Job | Cast, takes: int, size: int) -> list[Job | Cast]:
    """Return jobs of at most `size` takes each, which together make takes of `takes` seeds from the job's upward."""
    found = []
    for done in range(0, takes, size):
        own = {"seed": job.seed + done, "variants": min(size, takes - done)}
        if isinstance(job, Cast):
            members = (
                replace(each, job=replace(each.job, seed=each.job.seed + done)) for each in job.members
            )
            own["members"] = tuple(members)
        found.append(replace(job, **own))
    return found


def with_scene(text: str, scene: str) -> str:
    """Return a line for another file of the scene."""
    return json.dumps(json.loads(text) | {"scene": scene})


def count(path: Path) -> int:
    """Return how many lines a jobs file has, empty ones included."""
    return path.read_bytes().count(b"\n")


def _of_job(job: Job) -> dict[str, Any]:
    """Return the options of a job, without those that are left out."""
    if job.point is not None:
        raise SampError("A line of a jobs file cannot say which point of the furniture was clicked.")
    found = _of_steps(job.steps)
    found |= {name: getattr(job, name) for name in ("character", "start", "shape", "via")}
    found |= {name: getattr(job, name) for name in (*_SHARED, "seed", "variants")}
    return _plain(found)


def _of_steps(steps: Sequence[Step]) -> dict[str, Any]:
    """Return action, target, place, method and settings of the steps. Raise SampError where two steps differ in an
    option that a line has once."""
    settings: dict[str, Any] = {}
    for step in steps:
        for name, value in step.settings.items():
            if settings.setdefault(name, value) != value:
                raise SampError(f"Two steps differ in '{name}', which a line of a jobs file can have once.")
    names = ("action", "target", "method")
    if len(steps) == 1:
        return {name: getattr(steps[0], name) for name in names} | {"to": steps[0].to} | settings
    rows = {name: [getattr(step, name) for step in steps] for name in names}
    return rows | {"to": [step.to for step in steps if step.to is not None]} | settings


def _of_cast(cast: Cast) -> dict[str, Any]:
    """Return the options of a cast."""
    shared = {name: getattr(cast, name) for name in ("seed", "variants", "refine")}
    return _plain(shared) | {"cast": [_of_member(member, cast) for member in cast.members]}


def _of_member(member: Member, cast: Cast) -> dict[str, Any]:
    """Return a member's entry."""
    found = _of_job(member.job)
    del found["variants"]
    if member.job.seed == cast.seed:
        del found["seed"]
    own = {name: getattr(member, name) for name in ("name", "delay", "targets", "look_at")}
    return found | _plain(own)


def _plain(options: Mapping[str, Any]) -> dict[str, Any]:
    """Return options as JSON has them, without empty ones; an action is kept, for none is not the default."""
    found = json.loads(json.dumps(options, default=dict))
    return {name: value for name, value in found.items() if name == "action" or _given(value)}


def _given(value: Any) -> bool:
    return value is not None and value is not False and value not in ("", [], {})
