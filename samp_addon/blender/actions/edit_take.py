"""Edits of a take after it was made: a new Action for each, which the character then plays; the take stays."""

from __future__ import annotations

from collections.abc import Mapping

import bpy
import numpy as np

from ...edits import looping, retiming
from ...edits.looping import Loop
from ...motion import Motion
from .. import compat
from . import keyframes, notes
from .action_names import derived_name

RETIMED, LOOPED, IN_PLACE = " retimed", " loop", " in place"


def retime(
    context: bpy.types.Context,
    owner: bpy.types.Object,
    take: bpy.types.Action,
    factors: Mapping[str, float],
) -> bpy.types.Action:
    """Write a take with its phases faster or slower; see edits/retiming.py. Raise SampError, UsageError."""
    keyframes.require_editable(owner)
    motion = _read(context, owner, take)
    action = _written(context, owner, take, retiming.retimed(motion, factors).motion, RETIMED)
    for key in (notes.GOAL_KEY, notes.GROUND_KEY):
        if key in take:
            action[key] = take[key]
    return action


def loop(
    context: bpy.types.Context, owner: bpy.types.Object, take: bpy.types.Action, in_place: bool = False
) -> tuple[bpy.types.Action, Loop]:
    """Write the cycle of a take that closes best, repeated for ever; see edits/looping.py. Raise SampError."""
    keyframes.require_editable(owner)
    found = looping.looped(_read(context, owner, take), in_place)
    action = _written(context, owner, take, found.motion, IN_PLACE if in_place else LOOPED)
    for curve in compat.curves(action, owner):
        modifier = curve.modifiers.new("CYCLES")
        # Places go on from where the last cycle ended.
        mode = "REPEAT_OFFSET" if curve.data_path.endswith(".location") else "REPEAT"
        modifier.mode_before = modifier.mode_after = mode
    return action, found


def _read(context: bpy.types.Context, owner: bpy.types.Object, take: bpy.types.Action) -> Motion:
    return keyframes.read_motion(owner, take, _start(take), notes.take_end(take), scene=context.scene)


def _start(take: bpy.types.Action) -> int:
    return int(np.floor(take.frame_range[0]))


def _written(
    context: bpy.types.Context,
    owner: bpy.types.Object,
    take: bpy.types.Action,
    motion: Motion,
    suffix: str,
) -> bpy.types.Action:
    return keyframes.write_motion(owner, motion, derived_name(take, suffix), _start(take), context.scene)
