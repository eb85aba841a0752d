"""The cast list of the sidebar."""

from __future__ import annotations

import bpy

from ...vocabulary import SEATED
from ..panel import InPanel
from ..parts import buttons
from . import jobs


class SAMP_UL_cast(bpy.types.UIList):
    """The characters of the cast, one per row."""

    bl_idname = "SAMP_UL_cast"

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index) -> None:  # noqa: ANN001, PLR0913
        row = layout.row(align=True)
        row.label(text=jobs.label(item, index + 1), icon="ARMATURE_DATA" if item.character else "ADD")
        row.prop(item, "action", text="", emboss=False)
        row.prop(item, "target", text="", placeholder="Target" if item.action in SEATED else "Location")


class SAMP_PT_cast(InPanel, bpy.types.Panel):
    """Several characters that act at the same time"""

    bl_idname = "SAMP_PT_cast"
    bl_label = "Cast"

    def draw(self, context: bpy.types.Context) -> None:
        settings, layout = context.scene.samp, self.layout
        row = layout.row()
        row.template_list("SAMP_UL_cast", "", settings, "cast", settings, "cast_index", rows=3)
        column = row.column(align=True)
        for change, icon in (("ADD", "ADD"), ("REMOVE", "REMOVE"), ("UP", "TRIA_UP"), ("DOWN", "TRIA_DOWN")):
            button = column.row(align=True)
            button.enabled = change == "ADD" or len(settings.cast) > 0
            button.operator("samp.edit_cast", text="", icon=icon).change = change
        if 0 <= settings.cast_index < len(settings.cast):
            _draw_member(layout, settings.cast[settings.cast_index])
        buttons.draw(layout, "bake_cast", icon="PLAY")


def _draw_member(layout: bpy.types.UILayout, member: bpy.types.PropertyGroup) -> None:
    column = layout.column(align=True)
    column.prop(member, "character", text="", icon="ARMATURE_DATA", placeholder="New Human")
    if member.character is None:
        column.prop(member, "name")
    if member.target is None and member.action not in SEATED:
        layout.prop(member, "place")
    layout.prop(member, "delay")
    layout.prop(member, "look_at")
    layout.prop(member, "use_start")
    if member.use_start:
        layout.prop(member, "start", text="")
        layout.prop(member, "start_yaw")


CLASSES = (SAMP_UL_cast, SAMP_PT_cast)
