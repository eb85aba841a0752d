"""Delete Take: delete a take, or all takes without a star."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty

from .take_operator import TakeOperator


class SAMP_OT_delete_take(TakeOperator, bpy.types.Operator):
    """Delete this take from the file"""

    bl_idname = "samp.delete_take"
    bl_label = "Delete Take"

    unstarred: BoolProperty(
        name="All Without Star", description="Delete all takes without a star", options={"SKIP_SAVE"}
    )

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask before several takes are deleted."""
        if not self.unstarred or bpy.app.background:
            return self.execute(context)
        return context.window_manager.invoke_confirm(
            self, event, title="Delete all takes without a star?", confirm_text="Delete"
        )

    @classmethod
    def description(cls, context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        return "Delete all takes without a star, after asking" if properties.unstarred else cls.__doc__

    def take(self, context: bpy.types.Context) -> bpy.types.Action | None:
        return None if self.unstarred else super().take(context)

    def on_take(self, context: bpy.types.Context, take: bpy.types.Action | None) -> str:
        from ..samp_addon.blender.takes import take_list

        message = self._delete(take)
        character = context.scene.samp.character
        if character is not None:
            take_list.show_remaining(character)
        return message

    def _delete(self, take: bpy.types.Action | None) -> str:
        from ..samp_addon.blender.takes import take_list

        if take is not None:
            name = take.name
            take_list.delete(take)
            return f"Deleted '{name}'."
        deleted, kept = take_list.delete_unstarred()
        message = f"Deleted {deleted} take{'' if deleted == 1 else 's'}."
        return message + (f" Kept {kept} that are linked or played by NLA strips." if kept else "")
