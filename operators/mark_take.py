"""Mark Take: markers at the phases and steps of a take."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty

from .take_operator import TakeOperator


class SAMP_OT_mark_take(TakeOperator, bpy.types.Operator):
    """Add markers to this take's Action where walking, sitting down, the hold and standing up begin"""

    bl_idname = "samp.mark_take"
    bl_label = "Add Markers"

    phases: BoolProperty(name="Phases", description="Mark where each phase begins", default=True)
    steps: BoolProperty(name="Steps", description="Mark where each foot comes down")

    def on_take(self, context: bpy.types.Context, take: bpy.types.Action) -> str:
        from ..samp_addon.blender.edits import markers

        count = markers.mark(context, self.owner(context), take, self.phases, self.steps)
        return f"'{take.name}' has {count} markers."
