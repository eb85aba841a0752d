"""Retime Take: a copy of a take with its phases faster or slower."""

from __future__ import annotations

import bpy
from bpy.props import FloatProperty

from .take_operator import TakeOperator

_LIMITS = {"default": 1.0, "min": 0.25, "max": 4.0, "soft_min": 0.5, "soft_max": 2.0}


class SAMP_OT_retime_take(TakeOperator, bpy.types.Operator):
    """Copy this take with the walk, the sitting or lying down, and the hold each at a speed of its own"""

    bl_idname = "samp.retime_take"
    bl_label = "Retime Take"

    walk: FloatProperty(name="Walk", description="Speed of the way to the target", **_LIMITS)
    settle: FloatProperty(name="Sit Down", description="Speed of sitting or lying down", **_LIMITS)
    hold: FloatProperty(name="Hold", description="Speed of the rest on the target", **_LIMITS)

    def on_take(self, context: bpy.types.Context, take: bpy.types.Action) -> str:
        from ..samp_addon.blender.actions import edit_take

        factors = {"walk": self.walk, "settle": self.settle, "hold": self.hold}
        made = edit_take.retime(context, self.owner(context), take, factors)
        frames = made.frame_range[1] - made.frame_range[0] + 1
        return f"'{made.name}' has {frames:.0f} frames."
