"""Step Take: show the previous or the next take of the list."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty

from .take_operator import TakeOperator


class SAMP_OT_step_take(TakeOperator, bpy.types.Operator):
    """Show the previous or the next take of the list on the character"""

    bl_idname = "samp.step_take"
    bl_label = "Step Take"

    direction: EnumProperty(
        name="Direction",
        description="Which take to show",
        items=(
            ("PREVIOUS", "Previous", "Show the previous take of the list"),
            ("NEXT", "Next", "Show the next take of the list"),
        ),
        default="NEXT",
    )

    @classmethod
    def description(cls, context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        return cls.bl_rna.properties["direction"].enum_items[properties.direction].description

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        from ..samp_addon.blender.takes import take_list

        if not super().poll(context):
            return False
        if not take_list.listed(context.scene.samp):
            cls.poll_message_set("There is no take yet; generate one first")
            return False
        return True

    def take(self, context: bpy.types.Context) -> bpy.types.Action:
        from ..samp_addon.blender.takes import take_list

        return take_list.step(context.scene.samp, self.owner(context), 1 if self.direction == "NEXT" else -1)

    def on_take(self, context: bpy.types.Context, take: bpy.types.Action) -> str:
        from ..samp_addon.blender.takes import take_list

        take_list.show(context, self.owner(context), take)
        return f"Showing '{take.name}'."
