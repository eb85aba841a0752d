"""Turns the cast list, or the selection, into a cast. Cheap enough for every redraw until a cast is made."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import bpy

from ...blender.scene import candidates
from ...errors import SampError
from ...vocabulary import SEATED

if TYPE_CHECKING:
    from ...pipeline.cast.cast import Cast


def selected_characters(context: bpy.types.Context) -> list[bpy.types.Object]:
    """Return the SMPL-X armatures and other rigs that are selected, themselves or by a mesh that they deform."""
    from ...blender.rigs import performers

    found = []
    for obj in context.selected_objects:
        owner = obj if obj.type == "ARMATURE" else obj.find_armature() if obj.type == "MESH" else None
        if performers.is_performer(owner) and owner not in found:
            found.append(owner)
    return sorted(found, key=lambda obj: obj.name)


def of_selection(
    context: bpy.types.Context,
    action: str,
    common: dict,
    target: str = "",
    to: tuple[float, ...] | None = None,
) -> Cast | None:
    """Return the cast of the selected characters, None where there are not several.

    common: options that all jobs share. target: the furniture of all; if empty, the selected furniture. to: where they
    walk without a target. Raise SampError where there is nothing to sit or lie on.
    """
    from ...blender.scene import targets
    from ...pipeline.cast.cast import Cast, Member
    from ...pipeline.job import Job

    owners = selected_characters(context)
    if len(owners) < 2:
        return None
    names = [target] if target else []
    if not names and action in SEATED:
        names = list(dict.fromkeys(targets.whole(obj).name for obj in candidates.selected(context)))
        chosen = context.scene.samp.target
        names = names or ([chosen.name] if chosen is not None else [])
        if not names:
            raise SampError(f"{candidates.why_none(context)}; select furniture, or choose a target.")
    kept = {name: value for name, value in common.items() if name not in ("character", "variants", "start")}
    members = tuple(
        Member(
            Job(
                action=action,
                target=names[0] if names else "",
                to=None if names else to,
                character=owner.name,
                **kept,
            ),
            owner.name,
            targets=tuple(names) if action in SEATED else (),
        )
        for owner in owners
    )
    return Cast(members, common["seed"], common["variants"], common["refine"])


def why_not(context: bpy.types.Context) -> str:
    """Return why the cast list cannot be baked; empty where it can."""
    rows = context.scene.samp.cast
    if not len(rows):
        return "Add a character to the cast first"
    for number, row in enumerate(rows, start=1):
        if row.action in SEATED and row.target is None:
            return f"Choose what character {number} of the cast is to {row.action} on"
    return ""


def of_list(context: bpy.types.Context, common: dict) -> Cast:
    """Return the cast of the list. common: options that all jobs share. Raise SampError where a target is missing."""
    from ...pipeline.cast.cast import Cast, Member
    from ...pipeline.job import Job

    reason = why_not(context)
    if reason:
        raise SampError(f"{reason}.")
    kept = {name: value for name, value in common.items() if name not in ("character", "variants", "start")}
    members = []
    for number, row in enumerate(context.scene.samp.cast, start=1):
        start = (*row.start, math.degrees(row.start_yaw)) if row.use_start else None
        job = Job(
            action=row.action,
            target=row.target.name if row.target else "",
            to=None if row.target else tuple(row.place),
            character=row.character.name if row.character else "",
            start=start,
            **kept,
        )
        looked_at = row.look_at.name if row.look_at else ""
        members.append(Member(job, label(row, number), row.delay, look_at=looked_at))
    return Cast(tuple(members), common["seed"], common["variants"], common["refine"])


def label(row: bpy.types.PropertyGroup, number: int) -> str:
    """Return what a member of the list is called."""
    return row.character.name if row.character else row.name or f"Character {number}"
