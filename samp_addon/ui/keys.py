"""The pie menu, and the add-on's keys in the 3D view, which can be changed in the preferences."""

from __future__ import annotations

from typing import NamedTuple

import bpy

KEYMAP = "3D View"
PIE = (
    "sit_here",
    "lie_here",
    "walk_here",
    "place",
    "draw_path",
    "set_start",
    "redo_from_here",
    "follow_goal",
)
"""Operators in the order of Blender's pie menus: west, east, south, north, north-west, north-east, south-west and
south-east."""


class SAMP_MT_pie(bpy.types.Menu):
    """Show the most common tools around the mouse"""

    bl_idname = "SAMP_MT_pie"
    bl_label = "SAMP"

    def draw(self, context: bpy.types.Context) -> None:
        pie = self.layout.menu_pie()
        pie.operator_context = "INVOKE_DEFAULT"
        for name in PIE:
            pie.operator(f"samp.{name}")


class Key(NamedTuple):
    """A key, pressed with Shift and Alt, and the operator that it calls. menu: that ``wm.call_menu_pie`` shows; empty
    for other operators."""

    type: str
    operator: str
    menu: str = ""


# Both are free in Blender's own keymap and in the industry-compatible one.
KEYS = (Key("P", "wm.call_menu_pie", SAMP_MT_pie.bl_idname), Key("L", "samp.place"))
CLASSES = (SAMP_MT_pie,)

_made: list[tuple[bpy.types.KeyMap, bpy.types.KeyMapItem]] = []
"""The keys that `register` added, for `unregister`."""


def register() -> None:
    """Add the keys to the add-ons' keymap; Blender keeps the artist's changes beside it."""
    config = bpy.context.window_manager.keyconfigs.addon
    if config is None:  # Blender without a window
        return
    keymap = config.keymaps.new(name=KEYMAP, space_type="VIEW_3D")
    for key in KEYS:
        item = keymap.keymap_items.new(key.operator, key.type, "PRESS", shift=True, alt=True)
        if key.menu:
            item.properties.name = key.menu
        _made.append((keymap, item))


def unregister() -> None:
    """Remove the keys."""
    for keymap, item in _made:
        keymap.keymap_items.remove(item)
    _made.clear()


def draw(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    """Draw the keys of the user's keymap as rows in which they can be changed."""
    import rna_keymap_ui

    config = context.window_manager.keyconfigs.user
    keymap = config.keymaps.get(KEYMAP) if config is not None else None
    if keymap is None:
        return
    column = layout.column()
    column.label(text="Keys", icon="KEYINGSET")
    column.context_pointer_set("keymap", keymap)
    for key in KEYS:
        for item in keymap.keymap_items:
            if item.idname == key.operator and getattr(item.properties, "name", "") == key.menu:
                rna_keymap_ui.draw_kmi([], config, keymap, item, column, 0)
