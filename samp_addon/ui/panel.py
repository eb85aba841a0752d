"""The tab "SAMP" in the sidebar of the 3D view."""

from __future__ import annotations

import bpy

SECTIONS = (
    ("Character", "ARMATURE_DATA", ("create_character",)),
    ("Motion", "PLAY", ("sit_here", "lie_here", "walk_here")),
    ("Step by Step", "PRESET", ("voxelise", "sample_goals", "build_navmesh", "plan_path")),
    ("Takes", "ACTION", ("bake", "measure", "export_npz")),
)
WEIGHTS = ("foot", "collision", "contact", "smooth", "close", "limits", "goal")
CUSHION = '["samp_cushion"]'
# The operators that are registered; set by ui.register.
shown: tuple[str, ...] = ()


class _InSidebar:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "SAMP"


class SAMP_PT_panel(_InSidebar, bpy.types.Panel):
    """The operators, in the order in which an artist needs them."""

    bl_idname = "SAMP_PT_panel"
    bl_label = "SAMP"

    def draw(self, context: bpy.types.Context) -> None:
        for title, icon, names in SECTIONS:
            present = [name for name in names if name in shown]
            if not present:
                continue
            self.layout.label(text=title, icon=icon)
            column = self.layout.column(align=True)
            for name in present:
                column.operator(f"samp.{name}")


class _OfRefine(_InSidebar):
    """Shows the options with which Refine was last pressed, and will be pressed next."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return "refine" in shown

    @staticmethod
    def options(context: bpy.types.Context) -> bpy.types.OperatorProperties:
        return context.window_manager.operator_properties_last("samp.refine")


class SAMP_PT_refine(_OfRefine, bpy.types.Panel):
    """Refine, which part of the take it is for, and how soft the seat is."""

    bl_idname = "SAMP_PT_refine"
    bl_parent_id = "SAMP_PT_panel"
    bl_label = "Refine"

    def draw(self, context: bpy.types.Context) -> None:
        options, column = self.options(context), self.layout.column()
        column.operator("samp.refine")
        column.prop(options, "use_range")
        if options.use_range:
            row = column.row(align=True)
            row.prop(options, "frame_start", text="Start")
            row.prop(options, "frame_end", text="End")
        active = context.view_layer.objects.active
        if active is not None and CUSHION[2:-2] in active:
            column.prop(active, CUSHION, text="Cushion")
        else:
            column.operator("samp.set_cushion")


class SAMP_PT_refine_advanced(_OfRefine, bpy.types.Panel):
    """The weights of what is mended."""

    bl_idname = "SAMP_PT_refine_advanced"
    bl_parent_id = "SAMP_PT_refine"
    bl_label = "Advanced"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        options, column = self.options(context), self.layout.column()
        for name in ("strength", *WEIGHTS):
            column.prop(options, name)


CLASSES = (SAMP_PT_panel, SAMP_PT_refine, SAMP_PT_refine_advanced)
