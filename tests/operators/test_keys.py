"""The pie menu and its keys."""

from __future__ import annotations

from types import SimpleNamespace
from unittest.mock import MagicMock

import bpy
import pytest
import rna_keymap_ui
import samp_blender
from samp_blender.operators import OPERATORS
from samp_blender.samp_addon.ui import keys

pytestmark = pytest.mark.usefixtures("registered")


def items():
    """What the add-ons' keymap of the 3D view has of this one."""
    keymap = bpy.context.window_manager.keyconfigs.addon.keymaps.get(keys.KEYMAP)
    wanted = {key.operator for key in keys.KEYS}
    return [item for item in (keymap.keymap_items if keymap else ()) if item.idname in wanted]


def test_the_keys_call_the_pie_menu_and_place():
    found = {(item.type, item.idname, getattr(item.properties, "name", "")) for item in items()}
    assert found == {tuple(key) for key in keys.KEYS}
    assert all(item.shift and item.alt and not item.ctrl for item in items())


def test_the_pie_menu_has_eight_operators_that_exist():
    assert len(set(keys.PIE)) == 8 and set(keys.PIE) <= set(OPERATORS)


def test_the_keys_go_with_the_extension():
    samp_blender.unregister()
    assert items() == []
    samp_blender.register()
    assert len(items()) == len(keys.KEYS)


def test_the_keys_are_drawn_to_be_changed(monkeypatch):
    """In the preferences each key has a row of Blender's own keymap editor."""
    rows = []
    monkeypatch.setattr(
        rna_keymap_ui, "draw_kmi", lambda _, config, keymap, item, *rest: rows.append(item.type)
    )
    # Without a window Blender does not merge add-ons' keys into the user's keymap.
    configs = SimpleNamespace(user=bpy.context.window_manager.keyconfigs.addon)
    keys.draw(MagicMock(), SimpleNamespace(window_manager=SimpleNamespace(keyconfigs=configs)))
    assert rows == [key.type for key in keys.KEYS]
