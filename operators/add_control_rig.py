"""Add Control Rig: IK controls of a human's hands and feet, above any take."""

from __future__ import annotations

import bpy
from bpy.props import StringProperty

from . import outcome


class SAMP_OT_add_control_rig(bpy.types.Operator):
    """Add IK controls with poles for the hands and feet of a human, as a layer above all of its takes"""

    bl_idname = "samp.add_control_rig"
    bl_label = "Add Control Rig"
    bl_options = {"REGISTER", "UNDO"}

    character: StringProperty(
        name="Character",
        description="Human; if empty, the active one or the only one",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.has_character(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._add(context))

    def _add(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.controls import rig

        owner = rig.character(context, self.character)
        rig.add(context, owner)
        return f"'{owner.name}' has {len(rig.LIMBS)} controls and their poles; move or key them."
