"""The lists of the sidebar: takes with their measures, steps, and the bone table."""

from __future__ import annotations

import bpy

from ..blender.actions import notes
from ..blender.rigs import bone_table
from ..vocabulary import SEATED
from .panel import InPanel

COLUMNS = ("position_error_cm", "penetration_max_cm", "foot_slide_cm_s")
MEASURES = (
    ("position_error_cm", "Position Error", "cm"),
    ("rotation_error_deg", "Facing Error", "deg"),
    ("penetration_max_cm", "Penetration", "cm"),
    ("foot_slide_cm_s", "Foot Slide", "cm/s"),
    ("stance_slide_cm_s", "Stance Slide", "cm/s"),
)


class SAMP_UL_takes(bpy.types.UIList):
    """The Actions that are takes; a click shows one on the character."""

    bl_idname = "SAMP_UL_takes"

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index) -> None:  # noqa: ANN001, PLR0913
        row = layout.row(align=True)
        starred = notes.is_starred(item)
        row.operator(
            "samp.star_take", text="", icon="SOLO_ON" if starred else "SOLO_OFF", emboss=False
        ).action_name = item.name
        row.prop(item, "name", text="", emboss=False)
        numbers = notes.read_measures(item)
        for key in COLUMNS:
            cell = row.row()
            cell.alignment, cell.active = "RIGHT", False
            cell.label(text=f"{numbers[key]:.1f}" if key in numbers else "-")

    def filter_items(self, context, data, name) -> tuple[list[int], list[int]]:  # noqa: ANN001
        actions = getattr(data, name)
        wanted = self.filter_name.lower()
        flags = [
            self.bitflag_filter_item if notes.is_take(action) and wanted in action.name.lower() else 0
            for action in actions
        ]
        return flags, []


class SAMP_UL_steps(bpy.types.UIList):
    """The steps of a take, one per row."""

    bl_idname = "SAMP_UL_steps"

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index) -> None:  # noqa: ANN001, PLR0913
        row = layout.row(align=True)
        row.label(text=f"{index + 1}")
        row.prop(item, "action", text="", emboss=False)
        row.prop(
            item,
            "target",
            text="",
            placeholder="Target" if item.action in SEATED else "Location",
        )


class SAMP_UL_rig_map(bpy.types.UIList):
    """SMPL-X joints and the corresponding bones of another rig."""

    bl_idname = "SAMP_UL_rig_map"

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index) -> None:  # noqa: ANN001, PLR0913
        split = layout.split(factor=0.4)
        split.label(text=item.joint.replace("_", " "))
        split.prop_search(item, "bone", data.data, "bones", text="")


class SAMP_PT_takes(InPanel, bpy.types.Panel):
    """Takes of the file, to show, star, delete and push down"""

    bl_idname = "SAMP_PT_takes"
    bl_label = "Takes"
    bl_options = set()

    def draw(self, context: bpy.types.Context) -> None:
        settings, layout = context.scene.samp, self.layout
        row = layout.row()
        row.template_list(
            "SAMP_UL_takes", "", bpy.data, "actions", settings, "take_index", rows=4, sort_lock=True
        )
        chosen = _active_take(settings)
        column = row.column(align=True)
        for name, icon in (("push_down_take", "NLA_PUSHDOWN"), ("delete_take", "REMOVE")):
            button = column.row(align=True)
            button.enabled = chosen is not None
            made = button.operator(f"samp.{name}", text="", icon=icon)
            made.action_name = chosen.name if chosen is not None else ""
        fit = column.row(align=True)
        fit.enabled = chosen is not None
        made = fit.operator("samp.show_take", text="", icon="PREVIEW_RANGE")
        made.action_name, made.fit = chosen.name if chosen is not None else "", True
        column.separator()
        column.operator("samp.delete_take", text="", icon="TRASH").unstarred = True
        if chosen is not None:
            _draw_measures(layout, chosen)


class SAMP_PT_chain(InPanel, bpy.types.Panel):
    """Several actions in one take"""

    bl_idname = "SAMP_PT_chain"
    bl_label = "Steps"

    def draw(self, context: bpy.types.Context) -> None:
        settings, layout = context.scene.samp, self.layout
        row = layout.row()
        row.template_list("SAMP_UL_steps", "", settings, "steps", settings, "step_index", rows=3)
        column = row.column(align=True)
        for change, icon in (("ADD", "ADD"), ("REMOVE", "REMOVE"), ("UP", "TRIA_UP"), ("DOWN", "TRIA_DOWN")):
            column.operator("samp.edit_chain", text="", icon=icon).change = change
        if 0 <= settings.step_index < len(settings.steps):
            step = settings.steps[settings.step_index]
            if step.target is None and step.action not in SEATED:
                layout.prop(step, "place")
        layout.operator("samp.bake_chain", icon="PLAY")


class SAMP_PT_rig(InPanel, bpy.types.Panel):
    """The take on another rig, the active armature"""

    bl_idname = "SAMP_PT_rig"
    bl_label = "Other Rigs"

    def draw(self, context: bpy.types.Context) -> None:
        layout, active = self.layout, context.view_layer.objects.active
        layout.operator("samp.carry_to_rig", icon="ARMATURE_DATA")
        layout.operator("samp.guess_rig_map")
        if active is not None and active.type == "ARMATURE" and len(getattr(active, bone_table.TABLE)):
            layout.template_list(
                "SAMP_UL_rig_map", "", active, bone_table.TABLE, active, bone_table.ACTIVE, rows=6
            )


def _active_take(settings: bpy.types.PropertyGroup) -> bpy.types.Action | None:
    """Return the take that is active in the list, or None."""
    actions = bpy.data.actions
    action = actions[settings.take_index] if 0 <= settings.take_index < len(actions) else None
    return action if notes.is_take(action) else None


def _draw_measures(layout: bpy.types.UILayout, take: bpy.types.Action) -> None:
    """Draw the measures of a take; for a refined take also those of its source."""
    numbers = notes.read_measures(take)
    before = notes.read_measures(take, notes.BEFORE_KEY)
    column = layout.column(align=True)
    column.scale_y = 0.8
    for key, text, unit in MEASURES:
        if key in numbers:
            previous = f"{before[key]:.1f} \N{RIGHTWARDS ARROW} " if key in before else ""
            column.label(text=f"{text}: {previous}{numbers[key]:.1f} {unit}")


CLASSES = (SAMP_UL_takes, SAMP_UL_steps, SAMP_UL_rig_map, SAMP_PT_takes)
LATER = (SAMP_PT_chain, SAMP_PT_rig)
