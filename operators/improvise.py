"""Improvise: the character does something that fits what a camera sees."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.props import FloatProperty, IntProperty, StringProperty

from .job_operator import OptionsOperator

if TYPE_CHECKING:
    from ..samp_addon.pipeline.job import Job

METHOD = "scene_gan"


class SAMP_OT_improvise(OptionsOperator, bpy.types.Operator):
    """Do something that fits what the camera sees, without a target; another seed gives another idea"""

    bl_idname = "samp.improvise"
    bl_label = "Improvise"

    camera: StringProperty(
        name="Camera",
        description="Camera that sees the room; if empty, the selected one, or the scene's active one",
        options={"SKIP_SAVE"},
    )
    seconds: FloatProperty(
        name="Seconds", description="Length of the take, in seconds", default=4.0, min=1.0, max=120.0
    )
    draws: IntProperty(
        name="Draws", description="Most tries for each two seconds of the take", default=8, min=1, max=64
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        from ..samp_addon.ui import method_options

        if not super().poll(context):
            return False
        if not method_options.offered(METHOD):
            cls.poll_message_set("The networks of Improvise are not installed")
            return False
        return True

    def method_used(self, context: bpy.types.Context) -> str:
        return METHOD

    def job(self, context: bpy.types.Context) -> Job:
        from ..samp_addon.pipeline.job import Job

        active = context.view_layer.objects.active
        chosen = active.name if active is not None and active.type == "CAMERA" and active.select_get() else ""
        own = {"seconds": self.seconds, "draws": self.draws}
        camera = self.camera or chosen
        return Job(
            action="",
            method=METHOD,
            settings=own | ({"camera": camera} if camera else {}),
            **self.common(context),
        )
