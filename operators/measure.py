"""Measure: how good a take is, by the measures of the papers."""

from __future__ import annotations

import bpy
from bpy.props import StringProperty

from . import outcome


class SAMP_OT_measure(bpy.types.Operator):
    """Measure the character's take: goal, feet, contact and penetration"""

    bl_idname = "samp.measure"
    bl_label = "Measure"
    bl_options = {"REGISTER", "UNDO"}

    character: StringProperty(
        name="Character", description="SMPL-X armature; empty: the active one, or the only one"
    )
    action_name: StringProperty(name="Action", description="Which Action; empty: the active one")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.in_object_or_pose_mode(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._measure(context))

    def _measure(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.takes import measure

        name, numbers = measure.measure_take(context, self.character, self.action_name)
        text = measure.write_text(name, numbers)
        return measure.sentence(name, numbers, text.name)
