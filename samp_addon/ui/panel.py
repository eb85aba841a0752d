"""The tab "SAMP" in the sidebar of the 3D view, in the order of work.

Panels are redrawn many times a second: do not iterate over the scene's objects or import anything heavy here.
"""

from __future__ import annotations

import bpy

from ..blender.character import measures
from ..blender.scene import candidates
from ..methods import registry
from ..vocabulary import SEATED
from . import job_from_settings, method_options
from .parts import buttons, next_step, warm_up
from .presets import SAMP_PT_presets

# Collections of blender/overlays/goal_arrows.py and waypoints.py, which are not imported for their names alone.
GOALS, WAYPOINTS = "SAMP Goals", "SAMP Way-points"
CUSHION = '["samp_cushion"]'
ACTION_OPERATORS = ("sit_here", "lie_here", "walk_here", "place")


class InSidebar:
    """Mixin of all panels of the tab."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "SAMP"


class InPanel(InSidebar):
    """Mixin of the collapsible subpanels."""

    bl_parent_id = "SAMP_PT_panel"
    bl_options = {"DEFAULT_CLOSED"}


class SAMP_PT_panel(InSidebar, bpy.types.Panel):
    """Character, action and target, and the button that generates takes"""

    bl_idname = "SAMP_PT_panel"
    bl_label = "SAMP"

    def draw(self, context: bpy.types.Context) -> None:
        settings, layout = context.scene.samp, self.layout
        layout.label(text=next_step.sentence(context), icon="INFO")
        column = layout.column(align=True)
        column.prop(settings, "character", text="", icon="ARMATURE_DATA", placeholder="Character")
        if settings.character is None:
            made = column.operator("samp.create_character", icon="ADD")
            for name, value in measures.values(settings).items():
                setattr(made, name, value)
        if len(registry.METHODS) > 1:
            layout.prop(settings, "method")
        method = registry.find(settings.method)
        warm_up.begin(method.name)
        column, sub_goals = layout.column(align=True), job_from_settings.sub_goals(context)
        if method.actions and not sub_goals:
            column.row(align=True).prop(settings, "action", expand=True)
        if "target" in method.needs and not sub_goals:
            column.prop(settings, "target", text="", placeholder=_placeholder(context, settings))
        method_options.draw(layout, settings, method)
        row = layout.row(align=True)
        row.scale_y = 1.6
        buttons.draw(row, "generate", job_from_settings.button_label(context), "PLAY", also=ACTION_OPERATORS)
        row.prop(settings, "start_from", text="", icon_only=True)
        if method.actions:
            layout.operator("samp.place", icon="RESTRICT_SELECT_OFF")


class SAMP_PT_shape(InPanel, bpy.types.Panel):
    """Body shape of the next character"""

    bl_idname = "SAMP_PT_shape"
    bl_label = "Shape"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.scene.samp.character is None

    def draw(self, context: bpy.types.Context) -> None:
        measures.draw(self.layout, context.scene.samp)


class SAMP_PT_options(InPanel, bpy.types.Panel):
    """Number of takes and how they vary"""

    bl_idname = "SAMP_PT_options"
    bl_label = "Options"
    bl_options = set()

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        SAMP_PT_presets.draw_panel_header(self.layout)

    def draw(self, context: bpy.types.Context) -> None:
        settings, layout = context.scene.samp, self.layout
        layout.use_property_split, layout.use_property_decorate = True, False
        column = layout.column(align=True)
        for name in ("variants", "seed", "style", "hold", "speed"):
            column.prop(settings, name)
        column = layout.column(align=True)
        for name in ("refine", "fit_range", "mark_takes", "as_strip"):
            column.prop(settings, name)


class SAMP_PT_places(InPanel, bpy.types.Panel):
    """Goals and way-points to edit, and what the character sees of the scene"""

    bl_idname = "SAMP_PT_places"
    bl_label = "Goals and Path"

    def draw(self, context: bpy.types.Context) -> None:
        settings, layout = context.scene.samp, self.layout
        action = settings.action if settings.action in SEATED else "sit"
        column = layout.column(align=True)
        for name in ("sample_goals", "plan_path"):
            made = column.operator(f"samp.{name}")
            made.action = action
            if settings.target is not None:
                made.target = settings.target.name
        column.operator("samp.build_navmesh")
        column.operator("samp.voxelise")
        column = layout.column(align=True)
        column.operator("samp.add_waypoint", icon="ADD")
        column.operator("samp.draw_path", icon="GREASEPENCIL")
        column.operator("samp.set_start", icon="EMPTY_SINGLE_ARROW")
        for name, what, noun in ((GOALS, "GOALS", "goals"), (WAYPOINTS, "WAYPOINTS", "way-points")):
            count = _count(name)
            if count:
                row = layout.row()
                row.label(text=f"{count} {noun}")
                row.operator("samp.clear_overlays", text="", icon="X").what = what
        layout.operator("samp.clear_overlays")


class SAMP_PT_refine(InPanel, bpy.types.Panel):
    """Refinement of a take, and the cushion of the active seat"""

    bl_idname = "SAMP_PT_refine"
    bl_label = "Refine"
    bl_options = set()

    def draw(self, context: bpy.types.Context) -> None:
        options, layout = refine_options(context), self.layout
        column = layout.column(align=True)
        buttons.draw(column, "refine", icon="MOD_SMOOTH")
        column.prop(options, "strength", slider=True)
        layout.prop(options, "use_range")
        if options.use_range:
            row = layout.row(align=True)
            row.prop(options, "frame_start", text="Start")
            row.prop(options, "frame_end", text="End")
        active = context.view_layer.objects.active
        if active is not None and CUSHION[2:-2] in active:
            layout.prop(active, CUSHION, text="Cushion")
        else:
            layout.operator("samp.set_cushion")


class SAMP_PT_weights(InSidebar, bpy.types.Panel):
    """Weights of the optimiser's energies"""

    bl_idname = "SAMP_PT_weights"
    bl_parent_id = "SAMP_PT_refine"
    bl_label = "Advanced"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        options, column = refine_options(context), self.layout.column(align=True)
        for name in ("foot", "collision", "contact", "smooth", "close", "limits", "thin", "goal", "hand"):
            column.prop(options, name)


class SAMP_PT_export(InPanel, bpy.types.Panel):
    """Takes from and to files, and measures of a take"""

    bl_idname = "SAMP_PT_export"
    bl_label = "Import and Export"

    def draw(self, context: bpy.types.Context) -> None:
        column = self.layout.column(align=True)
        column.operator("samp.bake", icon="IMPORT")
        column.operator_menu_enum("samp.export_take", "kind", icon="EXPORT")
        self.layout.operator("samp.measure", icon="TEXT")


def refine_options(context: bpy.types.Context) -> bpy.types.OperatorProperties:
    """Return the last used options of Refine, which its next press uses too."""
    return context.window_manager.operator_properties_last("samp.refine")


def _placeholder(context: bpy.types.Context, settings: bpy.types.PropertyGroup) -> str:
    """Return the placeholder of an empty target."""
    if settings.action not in SEATED:
        return "3D Cursor"
    active = context.view_layer.objects.active
    return active.name if active is not None and candidates.is_furniture(active) else "Target"


def _count(collection: str) -> int:
    found = bpy.data.collections.get(collection)
    return 0 if found is None else len(found.objects)


CLASSES = (SAMP_PT_panel, SAMP_PT_shape, SAMP_PT_options)
LATER = (SAMP_PT_places, SAMP_PT_refine, SAMP_PT_weights)
LAST = (SAMP_PT_export,)
