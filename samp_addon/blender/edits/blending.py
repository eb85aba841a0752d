"""A take blended into or out of another Action of its character, as a new Action."""

from __future__ import annotations

from typing import Literal

import bpy

from ...edits.blending import Blend, blended
from ...errors import SampError
from ..actions import keyframes, notes
from ..actions.action_names import derived_name
from ..character.armature import bone_name
from ..compat import curves

SUFFIX = " blended"

Order = Literal["AFTER", "BEFORE"]
"""Whether the other Action comes after the take, or before it."""


def blend(
    context: bpy.types.Context,
    owner: bpy.types.Object,
    take: bpy.types.Action,
    other: bpy.types.Action,
    frames: int,
    order: Order = "AFTER",
) -> tuple[bpy.types.Action, Blend]:
    """Write a take and another Action in a row, blended over some frames; the new Action becomes the active one.

    The take stays where and when it is; the other one is moved to it, over the floor and in time. Raise SampError for
    an Action that does not animate the character's pelvis, and for too many frames.
    """
    keyframes.require_editable(owner)
    pelvis = f'pose.bones["{bpy.utils.escape_identifier(bone_name(owner, "pelvis"))}"]'
    if not any(curve.data_path.startswith(pelvis) for curve in curves(other, owner)):
        raise SampError(
            f"'{other.name}' does not animate the pelvis of '{owner.name}'; choose another Action."
        )
    first = round(take.frame_range[0])
    motion = keyframes.read_motion(owner, take, first, notes.take_end(take), context.scene)
    more = keyframes.read_motion(owner, other, scene=context.scene)
    made = blended(more, motion, frames, True) if order == "BEFORE" else blended(motion, more, frames)
    start = first - made.first if order == "BEFORE" else first
    action = keyframes.write_motion(owner, made.motion, derived_name(take, SUFFIX), start, context.scene)
    kept = (notes.GROUND_KEY, notes.GOAL_KEY) if order == "BEFORE" else (notes.GROUND_KEY,)
    for key in kept:
        if key in take:
            action[key] = take[key]
    return action, made
