"""The tab "SAMP" in the sidebar of the 3D view."""

from __future__ import annotations

import bpy

SECTIONS = (
    ("Character", "ARMATURE_DATA", ("create_character",)),
    ("Motion", "PLAY", ("sit_here", "lie_here", "walk_here")),
    ("Step by Step", "PRESET", ("voxelise", "sample_goals", "build_navmesh", "plan_path")),
    ("Takes", "ACTION", ("bake", "refine", "measure", "export_npz")),
)
# The operators that are registered; set by ui.register.
shown: tuple[str, ...] = ()


class SAMP_PT_panel(bpy.types.Panel):
    """The operators, in the order in which an artist needs them."""

    bl_idname = "SAMP_PT_panel"
    bl_label = "SAMP"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "SAMP"

    def draw(self, context: bpy.types.Context) -> None:
        for title, icon, names in SECTIONS:
            present = [name for name in names if name in shown]
            if not present:
                continue
            self.layout.label(text=title, icon=icon)
            column = self.layout.column(align=True)
            for name in present:
                column.operator(f"samp.{name}")


CLASSES = (SAMP_PT_panel,)
