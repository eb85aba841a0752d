"""Refine: contact, penetration, foot slide and smoothness of a take mended."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty, StringProperty

from .thread_operator import ThreadOperator

if TYPE_CHECKING:
    from ..samp_addon.blender.actions.refine_action import Result
    from ..samp_addon.blender.thread_run import ThreadRun

# The defaults are those of refine/refinement.py, which is not imported before it is used.
WEIGHTS = ("foot", "collision", "contact", "smooth", "close", "limits", "goal")


def _weight(name: str, description: str, default: float = 1.0) -> object:
    return FloatProperty(name=name, description=description, default=default, min=0.0, soft_max=4.0)


class SAMP_OT_refine(ThreadOperator, bpy.types.Operator):
    """Mend contact, penetration, foot slide and smoothness of the character's take, as a new Action"""

    bl_idname = "samp.refine"
    bl_label = "Refine"

    character: StringProperty(
        name="Character",
        description="SMPL-X armature; empty: the active one, or the only one",
        options={"SKIP_SAVE"},
    )
    action_name: StringProperty(
        name="Action", description="Which Action; empty: the active one", options={"SKIP_SAVE"}
    )
    use_range: BoolProperty(name="Part Only", description="Refine some frames of the Action, not all")
    frame_start: IntProperty(name="Start Frame", description="First frame of the part", default=1)
    frame_end: IntProperty(name="End Frame", description="Last frame of the part", default=250)
    strength: FloatProperty(
        name="Strength",
        description="Share of the change that is kept",
        default=1.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
    )
    foot: _weight("Feet", "Standing feet stay where they are")
    collision: _weight("Collision", "The body stays out of the scene")
    contact: _weight("Contact", "What rests on the scene touches it")
    smooth: _weight("Smoothness", "No jerks", 0.25)
    close: _weight("Closeness", "The take stays as it is")
    limits: _weight("Joint Limits", "No joint bends farther than a body can")
    goal: _weight("Goal", "The pelvis ends on its goal")

    def asked(self) -> dict:
        """What the function beneath is called with."""
        from ..samp_addon.refine.refinement import Settings

        weights = {name: getattr(self, name) for name in (*WEIGHTS, "strength")}
        return {
            "character": self.character,
            "action_name": self.action_name,
            "frame_start": self.frame_start if self.use_range else None,
            "frame_end": self.frame_end if self.use_range else None,
            "settings": Settings(**weights),
        }

    def run_now(self, context: bpy.types.Context) -> Result:
        from ..samp_addon.blender.actions import refine_action

        return refine_action.run(context, **self.asked())

    def begin(self, context: bpy.types.Context) -> ThreadRun:
        from ..samp_addon.blender.actions import refine_action

        return refine_action.begin(context, **self.asked())

    def finished(self, result: Result) -> str:
        from ..samp_addon.blender.actions import refine_action

        return refine_action.sentence(result)
