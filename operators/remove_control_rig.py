"""Remove Control Rig: the human alone again, with or without what the controls did."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, StringProperty

from . import outcome


class SAMP_OT_remove_control_rig(bpy.types.Operator):
    """Remove the IK controls of a human; its takes and everything else are as before the rig was added"""

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
        description="Write what the controls do into a copy of the active take first",
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
        return f"{text}." if applied is None else f"{text}; its moves are in '{applied.name}'."
