"""The tab "SAMP" in the sidebar of the 3D view, in the order in which an artist works.

It is drawn many times a second: nothing here looks at all objects of the scene or imports anything heavy.
"""

from __future__ import annotations

import bpy

from ..blender import running_work
from ..methods import registry
from ..motion import SEATED
from . import job_from_settings, method_options
from .settings import SHAPES

GOALS, WAYPOINTS = (
    "SAMP Goals",
    "SAMP Way-points",
)  # collections, see blender/goals.py and blender/waypoints.py
CUSHION = '["samp_cushion"]'


class InSidebar:
    """A panel of the tab."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "SAMP"


class InPanel(InSidebar):
    """A part of it that can be folded."""

    bl_parent_id = "SAMP_PT_panel"
    bl_options = {"DEFAULT_CLOSED"}


class SAMP_PT_panel(InSidebar, bpy.types.Panel):
    """Who does what, where: and the button."""

    bl_idname = "SAMP_PT_panel"
    bl_label = "SAMP"

    def draw(self, context: bpy.types.Context) -> None:
        settings, layout = context.scene.samp, self.layout
        column = layout.column(align=True)
        column.prop(settings, "character", text="", icon="ARMATURE_DATA", placeholder="Character")
        if settings.character is None:
            made = column.operator("samp.create_character", icon="ADD")
            for name, value in zip(SHAPES, settings.shape, strict=True):
                setattr(made, name, value)
        if len(registry.METHODS) > 1:
            layout.prop(settings, "method")
        method = registry.find(settings.method)
        column = layout.column(align=True)
        if method.actions:
            column.row(align=True).prop(settings, "action", expand=True)
        if "target" in method.needs:
            column.prop(settings, "target", text="", placeholder=_clicked(context, settings))
        method_options.draw(layout, settings, method)
        work = running_work.current()
        if work is None:
            row = layout.row()
            row.scale_y = 1.6
            row.operator("samp.generate", text=job_from_settings.word(settings), icon="PLAY")
        else:
            _draw_progress(layout, work.label, work.stage, work.share)


class SAMP_PT_shape(InPanel, bpy.types.Panel):
    """The figure of the next character."""

    bl_idname = "SAMP_PT_shape"
    bl_label = "Shape"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.scene.samp.character is None

    def draw(self, context: bpy.types.Context) -> None:
        column = self.layout.column(align=True)
        for number, name in enumerate(SHAPES):
            column.prop(context.scene.samp, "shape", index=number, text=name.capitalize(), slider=True)


class SAMP_PT_options(InPanel, bpy.types.Panel):
    """How many takes, and how they differ."""

    bl_idname = "SAMP_PT_options"
    bl_label = "Options"
    bl_options = set()

    def draw(self, context: bpy.types.Context) -> None:
        settings, layout = context.scene.samp, self.layout
        layout.use_property_split, layout.use_property_decorate = True, False
        column = layout.column(align=True)
        for name in ("variants", "seed", "style", "hold", "speed"):
            column.prop(settings, name)
        column = layout.column(align=True)
        column.prop(settings, "refine")
        column.prop(settings, "fit_range")


class SAMP_PT_places(InPanel, bpy.types.Panel):
    """Where to sit and how to get there, to be chosen and dragged."""

    bl_idname = "SAMP_PT_places"
    bl_label = "Goals and Path"

    def draw(self, context: bpy.types.Context) -> None:
        settings, layout = context.scene.samp, self.layout
        action = settings.action if settings.action in SEATED else "sit"
        column = layout.column(align=True)
        for name, text in (("sample_goals", "Find Goals"), ("plan_path", "Show Path")):
            made = column.operator(f"samp.{name}", text=text)
            made.action = action
            if settings.target is not None:
                made.target = settings.target.name
        column.operator("samp.build_navmesh", text="Show Navmesh")
        column.operator("samp.voxelise", text="Show Voxels")
        column = layout.column(align=True)
        column.operator("samp.add_waypoint", icon="ADD")
        for name, what, noun in ((GOALS, "GOALS", "goals"), (WAYPOINTS, "WAYPOINTS", "way-points")):
            count = _count(name)
            if count:
                row = layout.row()
                row.label(text=f"{count} {noun}")
                row.operator("samp.clear_overlays", text="", icon="X").what = what
        layout.operator("samp.clear_overlays", text="Clear All")


class SAMP_PT_refine(InPanel, bpy.types.Panel):
    """Refine, which part of the take it is for, how soft the seat is, and what it has changed.

    It shows the options with which Refine was last pressed, and will be pressed next.
    """

    bl_idname = "SAMP_PT_refine"
    bl_label = "Refine"
    bl_options = set()

    def draw(self, context: bpy.types.Context) -> None:
        options, layout = refine_options(context), self.layout
        column = layout.column(align=True)
        column.operator("samp.refine", icon="MOD_SMOOTH")
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
    """The weights of what is mended."""

    bl_idname = "SAMP_PT_weights"
    bl_parent_id = "SAMP_PT_refine"
    bl_label = "Advanced"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        options, column = refine_options(context), self.layout.column(align=True)
        for name in ("foot", "collision", "contact", "smooth", "close", "limits", "goal"):
            column.prop(options, name)


class SAMP_PT_export(InPanel, bpy.types.Panel):
    """Takes from and to files, and the report."""

    bl_idname = "SAMP_PT_export"
    bl_label = "Import and Export"

    def draw(self, context: bpy.types.Context) -> None:
        column = self.layout.column(align=True)
        column.operator("samp.bake", text="Import AMASS .npz", icon="IMPORT")
        for kind, text in (
            ("NPZ", "AMASS .npz"),
            ("FBX", "FBX"),
            ("GLTF", "glTF"),
            ("USD", "USD"),
            ("BVH", "BVH"),
        ):
            column.operator("samp.export_take", text=f"Export {text}", icon="EXPORT").kind = kind
        self.layout.operator("samp.measure", text="Report", icon="TEXT")


def refine_options(context: bpy.types.Context) -> bpy.types.OperatorProperties:
    """The options with which Refine was last pressed."""
    return context.window_manager.operator_properties_last("samp.refine")


def _draw_progress(layout: bpy.types.UILayout, name: str, stage: str, share: float) -> None:
    column = layout.column(align=True)
    column.progress(factor=share, text=f"{name}: {stage}")
    column.operator("samp.stop", icon="CANCEL")


def _clicked(context: bpy.types.Context, settings: bpy.types.PropertyGroup) -> str:
    """What an empty target stands for."""
    if settings.action not in SEATED:
        return "3D Cursor"
    active = context.view_layer.objects.active
    return active.name if active is not None and job_from_settings.is_furniture(active) else "Target"


def _count(collection: str) -> int:
    found = bpy.data.collections.get(collection)
    return 0 if found is None else len(found.objects)


CLASSES = (SAMP_PT_panel, SAMP_PT_shape, SAMP_PT_options)
LATER = (SAMP_PT_places, SAMP_PT_refine, SAMP_PT_weights)
LAST = (SAMP_PT_export,)
