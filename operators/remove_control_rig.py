"""Remove Control Rig: delete the IK controls of a human; optionally write their effect into a copy of its take."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, StringProperty

from . import outcome


class SAMP_OT_remove_control_rig(bpy.types.Operator):
    """Delete the IK controls of a human and what they change, and leave its takes as they are"""

    bl_idname = "samp.remove_control_rig"
    bl_label = "Remove Control Rig"
    bl_options = {"REGISTER", "UNDO"}

    character: StringProperty(
        name="Character",
        description="Human; if empty, the active one or the only one",
        options={"SKIP_SAVE"},
    )
    apply: BoolProperty(
        name="Apply",
        description="Write the effect of the controls into a copy of the active take before they are deleted",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.has_character(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._remove(context))

    def _remove(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.actions import keyframes
        from ..samp_addon.blender.controls import applying, rig

        owner = rig.character(context, self.character)
        applied = None
        if self.apply:
            applied = applying.apply(context, owner, keyframes.action_of(owner))
        rig.remove(context, owner)
        text = f"Removed the control rig of '{owner.name}'"
        return f"{text}." if applied is None else f"{text}; its effect is in '{applied.name}'."
