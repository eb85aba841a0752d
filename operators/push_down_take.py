"""Push Down Take: a take goes onto an NLA track of its own."""

from __future__ import annotations

import bpy

from .take_operator import TakeOperator


class SAMP_OT_push_down_take(TakeOperator, bpy.types.Operator):
    """Put this take on an NLA track of the character, where it can be moved and mixed"""

    bl_idname = "samp.push_down_take"
    bl_label = "Push Down Take"

    def on_take(self, context: bpy.types.Context, take: bpy.types.Action) -> str:
        from ..samp_addon.blender.takes import take_list

        owner = self.owner(context)
        track = take_list.push_down(owner, take)
        return f"'{take.name}' is on the NLA track '{track.name}' of '{owner.name}'."
