"""The SAMP menu in the object and pose menus and their context menus; F3 searches these."""

from __future__ import annotations

import bpy

from . import method_options

ENTRIES = (
    ("sit_here", "lie_here", "walk_here", "place", "improvise"),
    ("sample_goals", "plan_path", "build_navmesh", "add_waypoint", "draw_path", "set_start"),
    ("add_sub_goal", "sample_bodies", "pin_body", "use_current_pose", "remove_sub_goal", "clear_sub_goals"),
    ("refine", "look_at", "hand_target", "redo_from_here", "follow_goal", "set_cushion", "measure"),
    ("create_character", "bake", "export_take", "carry_to_rig", "add_control_rig", "remove_control_rig"),
)
METHODS = {"improvise": "scene_gan"} | dict.fromkeys(ENTRIES[2], "long_term")
"""Operators that are there only with the method of this name."""


class SAMP_MT_menu(bpy.types.Menu):
    """Operators for the selection"""

    bl_idname = "SAMP_MT_menu"
    bl_label = "SAMP"

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.operator_context = "INVOKE_DEFAULT"
        groups = [[name for name in names if _is_there(name)] for names in ENTRIES]
        for number, names in enumerate(filter(None, groups)):
            if number:
                self.layout.separator()
            for name in names:
                if name == "export_take":
                    self.layout.operator_menu_enum("samp.export_take", "kind")
                else:
                    self.layout.operator(f"samp.{name}")


def _is_there(name: str) -> bool:
    """Return whether the method of an operator is there."""
    return name not in METHODS or method_options.offered(METHODS[name])


def _entry(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    menu.layout.separator()
    menu.layout.menu(SAMP_MT_menu.bl_idname, icon="ARMATURE_DATA")


MENUS = ("VIEW3D_MT_object_context_menu", "VIEW3D_MT_object", "VIEW3D_MT_pose_context_menu", "VIEW3D_MT_pose")
CLASSES = (SAMP_MT_menu,)


def register() -> None:
    """Append the menu to Blender's menus."""
    for name in MENUS:
        getattr(bpy.types, name).append(_entry)


def unregister() -> None:
    """Remove the menu from Blender's menus."""
    for name in MENUS:
        getattr(bpy.types, name).remove(_entry)
