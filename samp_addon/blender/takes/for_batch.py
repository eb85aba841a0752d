"""Jobs as the batch has to have them, to make from a saved copy of the scene what the operators make here."""

from __future__ import annotations

from dataclasses import replace

import bpy

from ...errors import SampError
from ...pipeline.cast.cast import Cast
from ...pipeline.job import Job
from ..overlays import start_marker
from ..rigs import performers
from . import baking


def resolved(context: bpy.types.Context, job: Job | Cast, start_from: baking.StartFrom) -> Job | Cast:
    """Return the job with the character that it is for, and where that starts: the batch takes no character that is
    not named, and reads no start markers.

    start_from: as in baking.read. Raise SampError where the batch cannot do the same.
    """
    if isinstance(job, Cast):
        members = tuple(
            replace(member, job=start_marker.at_marker(context, member.job, _named(context, member.job)))
            for member in job.members
        )
        return replace(job, members=members)
    if start_from == "POSE":
        raise SampError("A farm cannot continue from the current pose; choose Start at Marker.")
    owner = baking.owner_of(context, job, False)
    if owner is not None:
        job = replace(job, character=owner.name, shape={})
    return start_marker.at_marker(context, job, owner)


def require_smplx(context: bpy.types.Context, job: Job | Cast, what: str) -> None:
    """Raise SampError where ``what`` needs an SMPL-X armature and a named character is another rig."""
    for member in getattr(job, "members", (job,)):
        name = getattr(member, "job", member).character
        performers.require_smplx(context.scene.objects.get(name) if name else None, what)


def _named(context: bpy.types.Context, job: Job) -> bpy.types.Object | None:
    return performers.find(context, job.character) if job.character else None
