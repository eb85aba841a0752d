"""Markers and a strip at the playhead for takes that have just been baked, as the artist's settings say."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import bpy

from ..character import armature
from ..takes import take_list
from . import markers


def apply(
    context: bpy.types.Context,
    takes: Mapping[bpy.types.Object, Sequence[bpy.types.Action]],
    mark: bool,
    strip: bool,
) -> list[bpy.types.NlaStrip]:
    """Mark the phases of new takes, and put the first one of each character onto an NLA track at the current frame.

    takes: the new Actions of each character. Phases are known on SMPL-X armatures only; other rigs get no markers.
    Return the new strips.
    """
    strips = []
    for owner, actions in takes.items():
        if mark and armature.is_smplx(owner):
            for action in actions:
                markers.mark(context, owner, action)
        if strip:
            strips.append(take_list.to_strip(owner, actions[0], context.scene.frame_current))
    return strips
