"""Guess Bones: fill the bone table of an armature from the names of its bones."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, StringProperty

from . import outcome


class SAMP_OT_guess_rig_map(bpy.types.Operator):
    """Fill the bone table of the active rig, which maps joints to bones when a take is carried to it"""

    bl_idname = "samp.guess_rig_map"
    bl_label = "Guess Bones"
    bl_options = {"REGISTER", "UNDO"}

    target: StringProperty(
        name="Rig",
        description="Armature whose bone table is filled; if empty, the active one",
        options={"SKIP_SAVE"},
    )
    keep: BoolProperty(
        name="Keep Rows", description="Do not change rows that are already filled", default=True
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.in_object_or_pose_mode(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._guess(context))

    def _guess(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.rigs import carry_to_rig

        return carry_to_rig.guess_sentence(carry_to_rig.guess_map(context, self.target, self.keep))
