"""Push Down Take: put a take on a new NLA track."""

from __future__ import annotations

import bpy

from .take_operator import TakeOperator


class SAMP_OT_push_down_take(TakeOperator, bpy.types.Operator):
    """Move this take to a new NLA track of the character"""

    bl_idname = "samp.push_down_take"
    bl_label = "Push Down Take"

    def on_take(self, context: bpy.types.Context, take: bpy.types.Action) -> str:
        from ..samp_addon.blender.takes import take_list

        owner = self.owner(context)
        track = take_list.push_down(owner, take)
        return f"'{take.name}' is on the NLA track '{track.name}' of '{owner.name}'."
