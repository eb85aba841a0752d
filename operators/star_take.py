"""Star Take: mark a take as one to keep."""

from __future__ import annotations

import bpy

from .take_operator import TakeOperator


class SAMP_OT_star_take(TakeOperator, bpy.types.Operator):
    """Set or clear the star of this take; deleting all takes without a star keeps it"""

    bl_idname = "samp.star_take"
    bl_label = "Star Take"

    def on_take(self, context: bpy.types.Context, take: bpy.types.Action) -> str:
        from ..samp_addon.blender.actions import notes

        return f"'{take.name}' has {'a' if notes.set_star(take) else 'no'} star now."
