"""Refine: correct contact, penetration, foot slide and smoothness of a take."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty, StringProperty

from . import outcome
from .thread_operator import ThreadOperator

if TYPE_CHECKING:
    from ..samp_addon.blender.actions.refine_action import Result
    from ..samp_addon.blender.thread_run import ThreadRun

# Defaults as in refine/refinement.py, which is imported only when the operator runs.
WEIGHTS = ("foot", "collision", "contact", "smooth", "close", "limits", "thin", "goal", "hand")


def _weight(name: str, description: str, default: float = 1.0) -> object:
    return FloatProperty(name=name, description=description, default=default, min=0.0, soft_max=4.0)


def _fill_range(options: bpy.types.OperatorProperties, context: bpy.types.Context) -> None:
    """Set the range to that of the Action that would be refined."""
    from ..samp_addon.blender.actions import keyframes
    from ..samp_addon.errors import SampError

    if not options.use_range:
        return
    try:
        _, action = keyframes.find_action(context, options.character, options.action_name)
    except SampError:  # reported when Refine runs
        return
    options.frame_start, options.frame_end = (round(frame) for frame in action.frame_range)


class SAMP_OT_refine(ThreadOperator, bpy.types.Operator):
    """Correct contact, penetration, foot slide and jerk of the character's take; the result becomes a new Action"""

    bl_idname = "samp.refine"
    bl_label = "Refine"

    character: StringProperty(
        name="Character",
        description="SMPL-X armature; if empty, the active one or the only one",
        options={"SKIP_SAVE"},
    )
    action_name: StringProperty(
        name="Action", description="Action to refine; if empty, the active one", options={"SKIP_SAVE"}
    )
    use_range: BoolProperty(
        name="Frame Range", description="Refine only the frames of a range", update=_fill_range
    )
    frame_start: IntProperty(name="Start Frame", description="First frame of the range", default=1)
    frame_end: IntProperty(name="End Frame", description="Last frame of the range", default=250)
    strength: FloatProperty(
        name="Strength",
        description="Fraction of the correction that is applied",
        default=1.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
    )
    foot: _weight("Feet", "Weight of keeping standing feet in place")
    collision: _weight("Collision", "Weight of keeping the body out of the scene")
    contact: _weight("Contact", "Weight of contact between resting body parts and the scene")
    smooth: _weight("Smoothness", "Weight of smooth motion", 0.25)
    close: _weight("Closeness", "Weight of staying close to the original take")
    limits: _weight("Joint Limits", "Weight of staying within joint limits")
    thin: _weight("Thin Things", "Weight of keeping thin seats, slats and wires out of the body")
    goal: _weight("Goal", "Weight of ending at the goal")
    hand: _weight("Hands", "Weight of keeping hands on their targets")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and outcome.has_action(cls, context)

    def _limit(self, name: str) -> int | None:
        """Return a limit of the range; None, the Action's, where it is not given."""
        return getattr(self, name) if self.use_range and self.properties.is_property_set(name) else None

    def arguments(self) -> dict:
        """Return the arguments of refine_action.run and begin."""
        from ..samp_addon.blender.actions import refine_action

        weights = {name: getattr(self, name) for name in (*WEIGHTS, "strength")}
        return {
            "character": self.character,
            "action_name": self.action_name,
            "frame_start": self._limit("frame_start"),
            "frame_end": self._limit("frame_end"),
            "settings": refine_action.Settings(**weights),
        }

    def run_now(self, context: bpy.types.Context) -> Result:
        from ..samp_addon.blender.actions import refine_action

        return refine_action.run(context, **self.arguments())

    def begin(self, context: bpy.types.Context) -> ThreadRun:
        from ..samp_addon.blender.actions import refine_action

        return refine_action.begin(context, **self.arguments())

    def finished(self, result: Result) -> str:
        from ..samp_addon.blender.actions import refine_action

        return refine_action.sentence(result)
