"""Hand Target: a hand on an object in some frames of a take."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from . import outcome


class SAMP_OT_hand_target(bpy.types.Operator):
    """Bring a hand of the character to the other selected object, with arm and trunk, as a new Action"""

    bl_idname = "samp.hand_target"
    bl_label = "Hand Target"
    bl_options = {"REGISTER", "UNDO"}

    hand: EnumProperty(
        name="Hand",
        description="Hand that is brought to the target",
        items=(("left", "Left", "The left hand"), ("right", "Right", "The right hand")),
        default="right",
    )
    target: StringProperty(
        name="Target",
        description="Empty or mesh that the palm touches; if empty, the other selected one",
        options={"SKIP_SAVE"},
    )
    vertex: IntProperty(
        name="Vertex",
        description="Index of the vertex that the palm touches; -1 for where the surface is nearest to the hand",
        default=-1,
        min=-1,
    )
    character: StringProperty(
        name="Character",
        description="SMPL-X armature; if empty, the active one or the only one",
        options={"SKIP_SAVE"},
    )
    use_range: BoolProperty(
        name="Frame Range", description="Choose the frames, which otherwise are those of the rest on the seat"
    )
    frame_start: IntProperty(
        name="Start Frame", description="First frame in which the palm is on the target", default=1
    )
    frame_end: IntProperty(
        name="End Frame", description="Last frame in which the palm is on the target", default=250
    )
    ease: FloatProperty(
        name="Ease",
        description="Time in which the hand moves to the target, and back, in seconds",
        default=0.5,
        min=0.0,
        max=10.0,
        subtype="TIME_ABSOLUTE",
    )

    grasp: BoolProperty(
        name="Grasp",
        description="Bend the fingers around the target until they touch it",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.has_action(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._bake(context))

    def _bake(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.actions import keyframes
        from ..samp_addon.blender.edits import hand_targets

        owner, _ = keyframes.find_action(context, self.character)
        target = outcome.other_object(context, owner, self.target)
        limits = (self.frame_start, self.frame_end) if self.use_range else (None, None)
        vertex = None if self.vertex < 0 else self.vertex
        return hand_targets.bake(
            context, target, self.hand, owner.name, *limits, self.ease, vertex, fingers=self.grasp
        ).sentence()
