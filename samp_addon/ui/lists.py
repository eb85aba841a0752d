"""The lists of the sidebar: steps, and the bone table."""

from __future__ import annotations

import bpy

from ..blender.rigs import bone_table
from ..methods import registry
from ..vocabulary import SEATED
from . import job_from_settings
from .panel import InPanel
from .parts import buttons


class SAMP_UL_steps(bpy.types.UIList):
    """The steps of a take, one per row."""

    bl_idname = "SAMP_UL_steps"

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index) -> None:  # noqa: ANN001, PLR0913
        row = layout.row(align=True)
        row.label(text=f"{index + 1}")
        if len(registry.METHODS) > 1:
            row.prop(item, "method", text="", emboss=False)
        if not job_from_settings.step_has_action(context, item):
            return
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
            button = column.row(align=True)
            button.enabled = change == "ADD" or len(settings.steps) > 0
            button.operator("samp.edit_chain", text="", icon=icon).change = change
        if 0 <= settings.step_index < len(settings.steps):
            step = settings.steps[settings.step_index]
            placed = step.use_yaw or (step.target is None and step.action not in SEATED)
            if placed and job_from_settings.step_has_action(context, step):
                layout.prop(step, "place")
                layout.prop(step, "use_yaw")
                if step.use_yaw:
                    layout.prop(step, "yaw")
            if step.posture:
                layout.prop(step, "posture")
        buttons.draw(layout, "bake_chain", icon="PLAY")


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


CLASSES = (SAMP_UL_steps, SAMP_UL_rig_map, SAMP_PT_chain, SAMP_PT_rig)
