"""Set Start: the start of a character's takes, shown as an arrow on the floor."""

from __future__ import annotations

import bpy
from bpy.props import StringProperty

from . import outcome


class SAMP_OT_set_start(bpy.types.Operator):
    """Move the start of the character's takes to where it stands now, and show it as an arrow that can be moved"""

    bl_idname = "samp.set_start"
    bl_label = "Set Start"
    bl_options = {"REGISTER", "UNDO"}

    character: StringProperty(
        name="Character",
        description="SMPL-X armature; if empty, the active one or the only one",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.has_character(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._set(context))

    def _set(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.actions import keyframes
        from ..samp_addon.blender.character import armature, start
        from ..samp_addon.blender.overlays import start_marker
        from ..samp_addon.ui import job_from_settings

        name = self.character or job_from_settings.character_name(context.scene.samp)
        owner = armature.find(context, name)
        keyframes.require_editable(owner)
        start.store(owner, armature.standing_floor(owner))
        return f"Takes of '{owner.name}' start at '{start_marker.show(context, owner).name}'."
