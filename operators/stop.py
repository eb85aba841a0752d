"""Stop: ends the work that is going on in the background; nothing is changed."""

from __future__ import annotations

import bpy

from ..samp_addon.blender import running_work


class SAMP_OT_stop(bpy.types.Operator):
    """Stop what is being made; nothing is changed"""

    bl_idname = "samp.stop"
    bl_label = "Cancel"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if running_work.current() is None:
            cls.poll_message_set("Nothing is being made")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        running_work.request_cancel()
        return {"FINISHED"}
