"""The same operators in the menus: a right click on an object, and through the menus also F3."""

from __future__ import annotations

import bpy

ENTRIES = (
    ("sit_here", "lie_here", "walk_here"),
    ("sample_goals", "plan_path", "build_navmesh", "add_waypoint"),
    ("refine", "set_cushion", "measure"),
    ("create_character", "bake", "export_take", "carry_to_rig"),
)


class SAMP_MT_menu(bpy.types.Menu):
    """All that can be done with what is selected."""

    bl_idname = "SAMP_MT_menu"
    bl_label = "SAMP"

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.operator_context = "INVOKE_DEFAULT"
        for number, names in enumerate(ENTRIES):
            if number:
                self.layout.separator()
            for name in names:
                self.layout.operator(f"samp.{name}")


def _entry(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    menu.layout.separator()
    menu.layout.menu(SAMP_MT_menu.bl_idname, icon="ARMATURE_DATA")


MENUS = ("VIEW3D_MT_object_context_menu", "VIEW3D_MT_object", "VIEW3D_MT_pose_context_menu", "VIEW3D_MT_pose")
CLASSES = (SAMP_MT_menu,)


def add() -> None:
    """Puts the menu into Blender's own."""
    for name in MENUS:
        getattr(bpy.types, name).append(_entry)


def remove() -> None:
    """Undoes add."""
    for name in MENUS:
        getattr(bpy.types, name).remove(_entry)
