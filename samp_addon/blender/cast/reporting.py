"""The report's entry of a cast's take."""

from __future__ import annotations

from collections.abc import Mapping

from ...pipeline.cast.cast_take import CastTake
from ...pipeline.cast.role import CastWork

MEMBER = (
    "seed", "method", "action", "target", "armature", "action_name", "frame_start", "frame_end", "goal_position",
    "goal_direction", "waypoints", "interaction_start", "sub_goals", "camera", "steps", "attempts", "metrics",
    "warnings",
)  # fmt: skip
"""What the report says of each member as of a job of its own."""


def entry(work: CastWork, take: CastTake, entries: Mapping[int, dict]) -> dict:
    """Return the entry of one take: that of its first member, with all members in `cast`.

    entries: the members' own, by number.
    """
    cast = [
        _member(work, take, number, own) | ({"refined": own["refined"]} if "refined" in own else {})
        for number, own in entries.items()
    ]
    first = next(iter(entries.values()))
    return first | {
        "seed": take.seed,
        "frame_end": max(own["frame_end"] for own in entries.values()),
        "cast": cast,
        "overlap_max_cm": round(100 * take.deepest, 3),
        "overlap_frames_percent": round(100 * take.overlapping, 3),
        "warnings": [
            f"'{own['armature']}': {warning}" for own in entries.values() for warning in own["warnings"]
        ],
    }


def _member(work: CastWork, take: CastTake, number: int, own: Mapping) -> dict:
    member = work.roles[number].member
    job = member.job
    return {
        "character": own["armature"],
        "to": None if job.to is None else list(job.to),
        "start": None if job.start is None else list(job.start),
        "delay": member.delay,
        "sets_off": round(take.waits.get(number, 0.0), 3),
        "name": member.name,
    } | {name: own[name] for name in MEMBER}
