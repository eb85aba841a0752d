"""Guess Bones: the bone table of an armature, filled in by its bones' names."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, StringProperty

from . import outcome


class SAMP_OT_guess_rig_map(bpy.types.Operator):
    """Fill in which bone of the active rig is which joint, for takes to be carried to it"""

    bl_idname = "samp.guess_rig_map"
    bl_label = "Guess Bones"
    bl_options = {"REGISTER", "UNDO"}

    target: StringProperty(
        name="Rig",
        description="Armature whose table is filled in; empty: the active one",
        options={"SKIP_SAVE"},
    )
    keep: BoolProperty(name="Keep Rows", description="Rows that are filled in stay as they are", default=True)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.in_object_or_pose_mode(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._guess(context))

    def _guess(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.rigs import carry_to_rig

        return carry_to_rig.guess_sentence(carry_to_rig.guess_map(context, self.target, self.keep))
