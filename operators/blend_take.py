"""Blend Take: a take and another Action in a row."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

from .take_operator import TakeOperator


class SAMP_OT_blend_take(TakeOperator, bpy.types.Operator):
    """Copy this take with another Action of the character blended into its beginning or its end"""

    bl_idname = "samp.blend_take"
    bl_label = "Blend Take"

    other: StringProperty(name="Other Action", description="Action that comes after or before the take")
    order: EnumProperty(
        name="Order",
        description="Where the other Action is",
        items=(
            ("AFTER", "After", "The take goes over into the other Action"),
            ("BEFORE", "Before", "The other Action goes over into the take"),
        ),
    )
    frames: IntProperty(
        name="Frames", description="Length of the blend in frames", default=15, min=1, soft_max=120
    )

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.prop_search(self, "other", bpy.data, "actions")
        self.layout.prop(self, "order", expand=True)
        self.layout.prop(self, "frames")

    def on_take(self, context: bpy.types.Context, take: bpy.types.Action) -> str:
        from ..samp_addon.blender.edits import blending
        from ..samp_addon.errors import SampError

        other = bpy.data.actions.get(self.other)
        if other is None:
            raise SampError(f"There is no Action '{self.other}'; choose one to blend the take with.")
        made, found = blending.blend(context, self.owner(context), take, other, self.frames, self.order)
        first = round(made.frame_range[0]) + found.first
        return f"'{made.name}' blends over frames {first} to {first + self.frames - 1}."
