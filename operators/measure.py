"""Measure Take: the measures of the papers for a take."""

from __future__ import annotations

import bpy
from bpy.props import StringProperty

from . import outcome


class SAMP_OT_measure(bpy.types.Operator):
    """Measure goal error, foot slide, contact and penetration of the character's take and write them to a text block"""

    bl_idname = "samp.measure"
    bl_label = "Measure Take"
    bl_options = {"REGISTER", "UNDO"}

    character: StringProperty(
        name="Character", description="SMPL-X armature; if empty, the active one or the only one"
    )
    action_name: StringProperty(name="Action", description="Action to measure; if empty, the active one")

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
