"""Send to Farm in the sidebar."""

from __future__ import annotations

import bpy

from ..panel import InPanel
from ..parts import buttons


class SAMP_PT_farm(InPanel, bpy.types.Panel):
    """Jobs for a render farm"""

    bl_idname = "SAMP_PT_farm"
    bl_label = "Farm"

    def draw(self, context: bpy.types.Context) -> None:
        settings, layout = context.scene.samp.farm, self.layout
        layout.row(align=True).prop(settings, "what", expand=True)
        layout.prop(settings, "folder", text="")
        column = layout.column(align=True)
        column.prop(settings, "takes")
        column.prop(settings, "per_line")
        column = layout.column(align=True)
        if settings.what == "TAKES":
            column.prop(settings, "each_selected")
        column.prop(settings, "blends")
        column.prop(settings, "previews")
        buttons.draw(layout, "send_to_farm", icon="EXPORT")


CLASSES = (SAMP_PT_farm,)
