"""The cast of a job: a list of JSON objects, each with options of one character over those of the job."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..errors import SampError, UsageError
from ..pipeline.cast.cast import Cast, Member, named
from ..pipeline.job import Job
from . import jobs_file

OWN = {"delay": float, "name": str, "targets": list, "look_at": str}
"""What an entry has beside a job's options."""

NOT_SHARED = ("action", "target", "to", "start", "character", "via", "path", "variants", "seed", "hand")
"""Options of the job that an entry does not take over where it has none: they are about one body, or the whole cast.
An action, a target and a place are taken over together, by entries that have none of them."""

WHAT = ("action", "target", "to", "targets")

FILES = (
    "scene",
    "output",
    "npz",
    "report",
    "preview",
    "dataset",
    "frames",
    "cast",
    "jobs",
    "units",
    "up",
    "overwrite",
    "variants",
)
"""Options that an entry cannot have."""


def read(path: Path) -> list:
    """Return the entries of a file. Raise UsageError where it cannot be read or holds something else."""
    try:
        found = json.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise UsageError(f"The cast file '{path}' cannot be read ({error.strerror}).") from error
    except (ValueError, RecursionError) as error:
        raise UsageError(f"The cast file '{path}' is not JSON ({error}).") from error
    return checked(found["cast"] if isinstance(found, dict) and "cast" in found else found)


def checked(entries: Any) -> list[dict]:
    """Return the entries of a cast. Raise UsageError where they are not a list of objects."""
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise UsageError('A cast is a list of objects, such as [{"action": "sit", "target": "Chair"}].')
    return entries


def cast(
    entries: Sequence[Mapping[str, Any]],
    shared: Mapping[str, Any],
    job_of: Callable[[Mapping[str, Any]], Job],
) -> Cast:
    """Return the cast of a list of entries. Raise UsageError, naming the member.

    shared: the parsed options of the job. job_of: returns the Job of parsed options.
    """
    jobs, own, names = [], [], []
    common = {name: value for name, value in shared.items() if name not in (*NOT_SHARED, *FILES)}
    what = {name: shared[name] for name in ("action", "target", "to") if name in shared}
    for number, entry in enumerate(entries, start=1):
        label = str(entry.get("name") or entry.get("character") or f"Character {number}")
        try:
            special = {name: _of_kind(name, entry[name]) for name in OWN if entry.get(name) is not None}
            given = {name: value for name, value in entry.items() if name not in OWN and value is not None}
            seed = {"seed": shared.get("seed", 0)}
            jobs.append(job_of(common | seed | _parsed(given, special, what)))
        except SampError as error:
            raise UsageError(f"'{label[:60]}': {error}") from error
        own.append(special)
        names.append(special.get("name", ""))
    members = tuple(
        Member(
            job,
            name,
            special.get("delay", 0.0),
            tuple(special.get("targets", ())),
            special.get("look_at", ""),
        )
        for job, name, special in zip(jobs, named(jobs, names), own, strict=True)
    )
    first = {name: shared[name] for name in ("seed", "variants", "refine") if name in shared}
    return Cast(members, **first)


def _parsed(given: Mapping[str, Any], special: Mapping[str, Any], what: Mapping[str, Any]) -> dict[str, Any]:
    """Return an entry's options as the command line's parser returns them."""
    for name in given:
        if name in FILES:
            raise UsageError(f"'{name}' is an option of the whole job; move it out of the cast.")
    options = jobs_file.parsed(given)
    if not any(name in given or name in special for name in WHAT):
        options = dict(what) | options
    if special.get("targets") and "target" not in options:
        options["target"] = [special["targets"][0]]
    return options


def _of_kind(name: str, value: Any) -> Any:
    """Return a value of an entry's own option. Raise UsageError for one of another kind."""
    kind = OWN[name]
    if kind is float and isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    if kind is list and isinstance(value, list) and value and all(isinstance(part, str) for part in value):
        return value
    if kind is str and isinstance(value, str):
        return value
    text = json.dumps(value)
    raise UsageError(f"'{name}' cannot be {text if len(text) <= 60 else text[:60] + ' ...'}.")
