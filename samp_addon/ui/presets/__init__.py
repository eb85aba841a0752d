"""Presets of the Options panel, as Blender presets: moods that come with the program, and the artist's own."""

from __future__ import annotations

from pathlib import Path

import bpy
from bl_ui.utils import PresetPanel

FOLDER = "samp"
"""Subfolder of the presets, here and in the artist's own scripts."""
SETTINGS = ("style", "hold", "speed", "samp_posture")
"""Settings of a scene that a preset holds."""


class SAMP_PT_presets(PresetPanel, bpy.types.Panel):
    """Presets of style, hold, speed and posture"""

    bl_label = "Take Presets"
    preset_subdir = FOLDER
    preset_operator = "script.execute_preset"
    preset_add_operator = "samp.add_preset"


CLASSES = (SAMP_PT_presets,)


def register() -> None:
    """Let Blender find the presets that come with the program."""
    if hasattr(bpy.utils, "register_preset_path"):
        bpy.utils.register_preset_path(str(_parent()))


def unregister() -> None:
    """Undo `register`."""
    if hasattr(bpy.utils, "unregister_preset_path"):
        bpy.utils.unregister_preset_path(str(_parent()))


def _parent() -> Path:
    """Return the folder whose subfolder ``presets`` Blender searches."""
    return Path(__file__).parent.parent
