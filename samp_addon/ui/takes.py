"""The list of takes: what each is worth, its measures, and what can be done with it."""

from __future__ import annotations

import bpy

from ..blender.actions import notes
from ..blender.takes import judgement, take_list
from .panel import InPanel

COLUMNS = (("penetration_max_cm", "Depth"), ("foot_slide_cm_s", "Slide"))
"""Measures in the list, and the head of their column."""
MEASURES = (
    ("position_error_cm", "Position Error", "cm"),
    ("rotation_error_deg", "Facing Error", "deg"),
    ("penetration_max_cm", "Penetration", "cm"),
    ("foot_slide_cm_s", "Foot Slide", "cm/s"),
    ("stance_slide_cm_s", "Stance Slide", "cm/s"),
)
ICONS = {
    "GOOD": "STRIP_COLOR_04",
    "DOUBTFUL": "STRIP_COLOR_03",
    "BAD": "STRIP_COLOR_01",
    "UNKNOWN": "STRIP_COLOR_09",
}
"""Green, yellow, red and grey."""
NAME_SHARE = 0.6
"""Share of a row's width that star, verdict and name take."""
EDITS = (
    ("retime_take", "TIME"),
    ("loop_take", "FILE_REFRESH"),
    ("reduce_keys", "IPO_BEZIER"),
    ("blend_take", "MOD_TIME"),
    ("redo_from_here", "RECOVER_LAST"),
    ("follow_goal", "CON_FOLLOWPATH"),
)
"""Operators that make an edited copy of a take."""
PLACED = (("take_to_strip", "NLA"), ("mark_take", "MARKER"), ("save_asset", "ASSET_MANAGER"))
"""Operators that do something with a take as it is."""
LONGEST = 14
"""Characters of a name that fit into the list at the sidebar's default width."""


class SAMP_UL_takes(bpy.types.UIList):
    """The Actions that are takes; a click shows one on the character."""

    bl_idname = "SAMP_UL_takes"

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index) -> None:  # noqa: ANN001, PLR0913
        verdict, _ = judgement.judge(item)
        split = layout.split(factor=NAME_SHARE, align=True)
        row = split.row(align=True)
        starred = notes.is_starred(item)
        row.operator(
            "samp.star_take", text="", icon="SOLO_ON" if starred else "SOLO_OFF", emboss=False
        ).action_name = item.name
        shown = row.operator("samp.show_take", text="", icon=ICONS[verdict], emboss=False)
        shown.action_name, shown.explain = item.name, True
        name = row.row(align=True)
        name.alert = verdict == "BAD"
        name.label(text=short_name(item.name))
        numbers = notes.read_measures(item)
        cells = split.row(align=True)
        for key, _ in COLUMNS:
            cell = cells.row()
            cell.alignment, cell.active = "RIGHT", False
            cell.label(text=f"{numbers[key]:.1f}" if key in numbers else "-")

    def filter_items(self, context, data, name) -> tuple[list[int], list[int]]:  # noqa: ANN001
        listed, wanted = set(take_list.listed(context.scene.samp)), self.filter_name.lower()
        flags = [
            self.bitflag_filter_item if action in listed and wanted in action.name.lower() else 0
            for action in getattr(data, name)
        ]
        return flags, []


class SAMP_PT_takes(InPanel, bpy.types.Panel):
    """Takes of the file, to show, star, delete and push down"""

    bl_idname = "SAMP_PT_takes"
    bl_label = "Takes"
    bl_options = set()

    def draw(self, context: bpy.types.Context) -> None:
        settings, layout = context.scene.samp, self.layout
        chosen = _active_take(settings)
        row = layout.row()
        column = row.column(align=True)
        _draw_heads(column)
        column.template_list(
            "SAMP_UL_takes", "", bpy.data, "actions", settings, "take_index", rows=4, sort_lock=True
        )
        _draw_buttons(row.column(align=True), chosen)
        row = layout.row(align=True)
        for direction, icon in (("PREVIOUS", "TRIA_LEFT"), ("NEXT", "TRIA_RIGHT")):
            row.operator("samp.step_take", text="", icon=icon).direction = direction
        if chosen is None:
            row.label(text="No take is active")
        else:
            row.prop(chosen, "name", text="")
        row.prop(settings, "only_character", text="", icon="ARMATURE_DATA")
        row = layout.row()
        row.prop(settings, "show_trails")
        row.prop(settings, "auto_follow")
        if chosen is not None:
            _draw_measures(layout, chosen)


class SAMP_MT_edit_take(bpy.types.Menu):
    """Edits of the take that is active in the list; each makes a new one"""

    bl_idname = "SAMP_MT_edit_take"
    bl_label = "Edit Take"

    def draw(self, context: bpy.types.Context) -> None:
        chosen = _active_take(context.scene.samp)
        name = "" if chosen is None else chosen.name
        self.layout.operator_context = "INVOKE_DEFAULT"
        for number, operators in enumerate((EDITS, PLACED)):
            if number:
                self.layout.separator()
            for operator, icon in operators:
                self.layout.operator(f"samp.{operator}", icon=icon).action_name = name


def short_name(name: str) -> str:
    """Return a name that fits into the list: its beginning and its last word, which is the seed."""
    if len(name) <= LONGEST:
        return name
    head, _, tail = name.rpartition(" ")
    room = LONGEST - len(tail) - 2
    if not head or room < 4:
        return name[: LONGEST - 1] + "\N{HORIZONTAL ELLIPSIS}"
    return f"{head[:room].rstrip()}\N{HORIZONTAL ELLIPSIS} {tail}"


def _draw_heads(layout: bpy.types.UILayout) -> None:
    split = layout.split(factor=NAME_SHARE, align=True)
    split.label(text="Take")
    cells = split.row(align=True)
    for _, head in COLUMNS:
        cell = cells.row()
        cell.alignment, cell.active = "RIGHT", False
        cell.label(text=head)


def _draw_buttons(column: bpy.types.UILayout, chosen: bpy.types.Action | None) -> None:
    """Draw the buttons beside the list."""
    name = "" if chosen is None else chosen.name
    for operator, icon in (("push_down_take", "NLA_PUSHDOWN"), ("delete_take", "REMOVE")):
        button = column.row(align=True)
        button.enabled = chosen is not None
        button.operator(f"samp.{operator}", text="", icon=icon).action_name = name
    fit = column.row(align=True)
    fit.enabled = chosen is not None
    made = fit.operator("samp.show_take", text="", icon="PREVIEW_RANGE")
    made.action_name, made.fit = name, True
    column.separator()
    edit = column.row(align=True)
    edit.enabled = chosen is not None
    edit.menu("SAMP_MT_edit_take", text="", icon="DOWNARROW_HLT")
    column.operator("samp.delete_take", text="", icon="TRASH").unstarred = True


def _active_take(settings: bpy.types.PropertyGroup) -> bpy.types.Action | None:
    """Return the take that is active in the list, or None."""
    actions = bpy.data.actions
    action = actions[settings.take_index] if 0 <= settings.take_index < len(actions) else None
    return action if notes.is_take(action) else None


def _draw_measures(layout: bpy.types.UILayout, take: bpy.types.Action) -> None:
    """Draw the verdict and the measures of a take; for a refined take also those of its source."""
    numbers = notes.read_measures(take)
    before = notes.read_measures(take, notes.BEFORE_KEY)
    column = layout.column(align=True)
    column.scale_y = 0.8
    verdict, reason = judgement.judge(take)
    if verdict in ("DOUBTFUL", "BAD"):
        for line in reason.splitlines():
            column.label(text=line, icon=ICONS[verdict])
    for key, text, unit in MEASURES:
        if key in numbers:
            previous = f"{before[key]:.1f} \N{RIGHTWARDS ARROW} " if key in before else ""
            column.label(text=f"{text}: {previous}{numbers[key]:.1f} {unit}")


CLASSES = (SAMP_UL_takes, SAMP_MT_edit_take, SAMP_PT_takes)
