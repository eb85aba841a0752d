"""Cancel: stop the work in the background."""

from __future__ import annotations

import bpy

from ..samp_addon.blender import running_work


class SAMP_OT_stop(bpy.types.Operator):
    """Stop the work in the background and discard its result"""

    bl_idname = "samp.stop"
    bl_label = "Cancel"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if running_work.current() is None:
            cls.poll_message_set("There is no work in progress")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        running_work.request_cancel()
        return {"FINISHED"}
