"""Look At: the character looks at an object in some frames of its take."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty, StringProperty

from . import outcome


class SAMP_OT_look_at(bpy.types.Operator):
    """Turn the character's head and eyes to the other selected object, as far as the neck allows, as a new Action"""

    bl_idname = "samp.look_at"
    bl_label = "Look At"
    bl_options = {"REGISTER", "UNDO"}

    target: StringProperty(
        name="Target",
        description="Object or character to look at; if empty, the other selected one",
        options={"SKIP_SAVE"},
    )
    character: StringProperty(
        name="Character",
        description="SMPL-X armature; if empty, the active one or the only one",
        options={"SKIP_SAVE"},
    )
    use_range: BoolProperty(
        name="Frame Range", description="Look at the target only in the frames of a range"
    )
    frame_start: IntProperty(
        name="Start Frame", description="Frame in which the head begins to turn", default=1
    )
    frame_end: IntProperty(
        name="End Frame", description="Frame in which the head has turned back", default=250
    )
    ease: FloatProperty(
        name="Ease",
        description="Time in which the head turns, in seconds",
        default=0.5,
        min=0.0,
        max=10.0,
        subtype="TIME_ABSOLUTE",
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.has_action(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._bake(context))

    def _bake(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.actions import keyframes
        from ..samp_addon.blender.cast import looking

        owner, _ = keyframes.find_action(context, self.character)
        target = outcome.other_object(context, owner, self.target)
        limits = (self.frame_start, self.frame_end) if self.use_range else (None, None)
        action = looking.bake(context, target, owner.name, *limits, self.ease)
        return f"'{owner.name}' looks at '{target.name}' in '{action.name}'."
