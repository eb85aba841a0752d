"""Loop Take: one cycle of a take that repeats for ever."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty

from .take_operator import TakeOperator


class SAMP_OT_loop_take(TakeOperator, bpy.types.Operator):
    """Copy the part of this take that repeats best, two steps of a walk, as a cycle without end"""

    bl_idname = "samp.loop_take"
    bl_label = "Loop Take"

    in_place: BoolProperty(
        name="In Place",
        description="Keep the pelvis over one place, as on a treadmill, for an object that is moved along a path",
    )

    def on_take(self, context: bpy.types.Context, take: bpy.types.Action) -> str:
        from ..samp_addon.blender.actions import edit_take

        made, found = edit_take.loop(context, self.owner(context), take, self.in_place)
        return f"'{made.name}' repeats {len(found.motion) - 1} frames."
