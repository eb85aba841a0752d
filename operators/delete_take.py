"""Delete Take: takes a take, or all without a star, out of the file."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty

from .take_operator import TakeOperator


class SAMP_OT_delete_take(TakeOperator, bpy.types.Operator):
    """Delete this take"""

    bl_idname = "samp.delete_take"
    bl_label = "Delete Take"

    unstarred: BoolProperty(
        name="All Without Star", description="Every take that has no star", options={"SKIP_SAVE"}
    )

    def take(self, context: bpy.types.Context) -> bpy.types.Action | None:
        return None if self.unstarred else super().take(context)

    def on_take(self, context: bpy.types.Context, take: bpy.types.Action | None) -> str:
        from ..samp_addon.blender.takes import take_list

        told = self._deleted(take)
        chosen = context.scene.samp.character
        if chosen is not None:
            take_list.show_remaining(chosen)
        return told

    def _deleted(self, take: bpy.types.Action | None) -> str:
        from ..samp_addon.blender.takes import take_list

        if take is not None:
            name = take.name
            take_list.delete(take)
            return f"Deleted '{name}'."
        deleted, kept = take_list.delete_unstarred()
        told = f"Deleted {deleted} take{'' if deleted == 1 else 's'}."
        return told + (f" {kept} that NLA strips play or that are linked were kept." if kept else "")
