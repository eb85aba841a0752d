"""Carry to Rig: a take of an SMPL-X character for a Mixamo, Unreal, Rigify or other rig."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, IntProperty, StringProperty

from . import outcome


class SAMP_OT_carry_to_rig(bpy.types.Operator):
    """Carry the character's take to the active rig as a new Action, and keep the contacts of feet and pelvis"""

    bl_idname = "samp.carry_to_rig"
    bl_label = "Carry to Rig"
    bl_options = {"REGISTER", "UNDO"}

    target: StringProperty(
        name="Rig",
        description="Armature that receives the take; if empty, the active one",
        options={"SKIP_SAVE"},
    )
    character: StringProperty(
        name="Character",
        description="SMPL-X armature with the take; if empty, the selected one or the only other one",
        options={"SKIP_SAVE"},
    )
    action_name: StringProperty(
        name="Action", description="The take; if empty, the character's active Action", options={"SKIP_SAVE"}
    )
    use_range: BoolProperty(name="Frame Range", description="Carry only the frames of a range")
    frame_start: IntProperty(name="Start Frame", description="First frame of the range", default=1)
    frame_end: IntProperty(name="End Frame", description="Last frame of the range", default=250)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.in_object_or_pose_mode(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._carry(context))

    def _carry(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.rigs import carry_to_rig

        return carry_to_rig.sentence(
            carry_to_rig.carry_to_rig(
                context,
                self.target,
                self.character,
                self.action_name,
                self.frame_start if self.use_range else None,
                self.frame_end if self.use_range else None,
            )
        )
