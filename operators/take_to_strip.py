"""Take to Strip: a take as an NLA strip at the current frame."""

from __future__ import annotations

import bpy

from .take_operator import TakeOperator


class SAMP_OT_take_to_strip(TakeOperator, bpy.types.Operator):
    """Put this take as a strip onto a new NLA track of the character, from the current frame on"""

    bl_idname = "samp.take_to_strip"
    bl_label = "Take to Strip"

    def on_take(self, context: bpy.types.Context, take: bpy.types.Action) -> str:
        from ..samp_addon.blender.takes import take_list

        owner = self.owner(context)
        strip = take_list.to_strip(owner, take, context.scene.frame_current)
        first, last = strip.frame_start, strip.frame_end
        return f"'{take.name}' is a strip of '{owner.name}' from frame {first:.0f} to {last:.0f}."
