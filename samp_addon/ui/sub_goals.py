"""The sub-goals in the sidebar: their list, and what can be done with them."""

from __future__ import annotations

import bpy

from ..blender.sub_goals import arrows
from ..methods import registry
from . import sub_goal_settings
from .panel import InPanel


class SAMP_UL_sub_goals(bpy.types.UIList):
    """The sub-goals of the character in the order of the take; a click selects the arrow"""

    bl_idname = "SAMP_UL_sub_goals"

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index) -> None:  # noqa: ANN001, PLR0913
        from ..blender.sub_goals import stored

        row = layout.row(align=True)
        wrong = bool(stored.problem(item))
        row.alert = wrong
        row.label(text=item.name, icon="ERROR" if wrong else "EMPTY_SINGLE_ARROW")
        pinned = stored.is_pinned(item)
        row.operator(
            "samp.pin_body", text="", icon="PINNED" if pinned else "UNPINNED", emboss=False
        ).sub_goal = item.name

    def filter_items(self, context, data, name) -> tuple[list[int], list[int]]:  # noqa: ANN001
        return filtered(context, getattr(data, name), self.filter_name.lower(), self.bitflag_filter_item)


class SAMP_PT_sub_goals(InPanel, bpy.types.Panel):
    """Places that the take passes, each with a body"""

    bl_idname = "SAMP_PT_sub_goals"
    bl_label = "Sub-goals"
    bl_options = set()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return "sub_goals" in registry.find(context.scene.samp.method).needs

    def draw(self, context: bpy.types.Context) -> None:
        layout, settings = self.layout, context.scene.samp
        row = layout.row(align=True)
        row.operator("samp.add_sub_goal", icon="ADD")
        row.operator("samp.add_sub_goal", text="", icon="EYEDROPPER").click = True
        home, owner = arrows.collection(context.scene), sub_goal_settings.owner(context)
        if not arrows.listed(context, owner):
            return
        row = layout.row()
        row.template_list(
            "SAMP_UL_sub_goals", "", home, "objects", settings, "sub_goal_index", rows=4, sort_lock=True
        )
        column = row.column(align=True)
        column.operator("samp.remove_sub_goal", text="", icon="REMOVE")
        for direction, icon in (("UP", "TRIA_UP"), ("DOWN", "TRIA_DOWN")):
            column.operator("samp.move_sub_goal", text="", icon=icon).direction = direction
        column.separator()
        column.operator("samp.clear_sub_goals", text="", icon="TRASH")
        column = layout.column(align=True)
        row = column.row(align=True)
        row.operator("samp.sample_bodies", icon="FILE_REFRESH")
        row.operator("samp.pin_body", icon="PINNED")
        column.operator("samp.use_current_pose", icon="POSE_HLT")
        _draw_problem(layout, sub_goal_settings.current(context))


def filtered(
    context: bpy.types.Context, objects: bpy.types.bpy_prop_collection, wanted: str, flag: int
) -> tuple[list[int], list[int]]:
    """Return which objects a list shows, and the place of each: the sub-goals in the order of the take.

    wanted: part of a name, in lower case. flag: of what is shown.
    """
    order = arrows.listed(context, sub_goal_settings.owner(context))
    ranks = {arrow.name: rank for rank, arrow in enumerate(order)}
    flags = [flag if obj.name in ranks and wanted in obj.name.lower() else 0 for obj in objects]
    rest = iter(range(len(order), len(objects)))
    return flags, [ranks[obj.name] if obj.name in ranks else next(rest) for obj in objects]


def _draw_problem(layout: bpy.types.UILayout, arrow: bpy.types.Object | None) -> None:
    """Draw why no body fits at a sub-goal, half a sentence a line."""
    from ..blender.sub_goals import stored

    if arrow is None or not stored.problem(arrow):
        return
    column = layout.column(align=True)
    column.scale_y = 0.8
    for number, line in enumerate(stored.problem(arrow).split("; ")):
        column.label(text=line, icon="NONE" if number else "ERROR")


CLASSES = (SAMP_UL_sub_goals, SAMP_PT_sub_goals)
