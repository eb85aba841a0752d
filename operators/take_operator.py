"""Base of the operators of the takes list: the take and its character."""

from __future__ import annotations

import bpy
from bpy.props import StringProperty

from . import outcome


class TakeOperator:
    """Base class; subclasses implement `on_take`."""

    bl_options = {"REGISTER", "UNDO"}

    action_name: StringProperty(
        name="Action",
        description="Name of the take; if empty, the character's active one",
        options={"SKIP_SAVE"},
    )
    character: StringProperty(
        name="Character",
        description="SMPL-X armature or other rig; if empty, the active one or the only one",
        options={"SKIP_SAVE"},
    )

    def on_take(self, context: bpy.types.Context, take: bpy.types.Action) -> str:
        """Do the work on a take and return the message to report."""
        raise NotImplementedError

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.in_object_or_pose_mode(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self.on_take(context, self.take(context)))

    def owner(self, context: bpy.types.Context) -> bpy.types.Object:
        """Return the character. Raise SampError where there is none."""
        from ..samp_addon.blender.rigs import performers
        from ..samp_addon.ui import job_from_settings

        return performers.find(
            context, self.character or job_from_settings.character_name(context.scene.samp)
        )

    def take(self, context: bpy.types.Context) -> bpy.types.Action:
        """Return the take. Raise SampError where there is none."""
        from ..samp_addon.blender.actions import notes
        from ..samp_addon.blender.takes import take_list
        from ..samp_addon.errors import SampError

        name = self.action_name
        if not name:
            data = self.owner(context).animation_data
            if data is None or not notes.is_take(data.action):
                raise SampError("The character has no active take; choose one from the list.")
            name = data.action.name
        return take_list.find(name)
