"""Add Take Preset: store or remove a preset of the Options panel, in the way of Blender's own presets."""

from __future__ import annotations

import bpy
from bl_operators.presets import AddPresetBase
from bpy.props import BoolProperty, StringProperty

from ..samp_addon.ui import presets


class SAMP_OT_add_preset(AddPresetBase, bpy.types.Operator):
    """Add or remove a preset of style, hold, speed and posture"""

    bl_idname = "samp.add_preset"
    bl_label = "Add Take Preset"
    preset_menu = "SAMP_PT_presets"
    preset_subdir = presets.FOLDER
    preset_defines = ("samp = bpy.context.scene.samp",)
    preset_values = tuple(f"samp.{name}" for name in presets.SETTINGS)

    name: StringProperty(name="Name", description="Name of the preset", options={"SKIP_SAVE"})
    remove_name: BoolProperty(
        name="Remove This Name", description="Remove the preset of this name", options={"HIDDEN", "SKIP_SAVE"}
    )
    remove_active: BoolProperty(
        name="Remove Active", description="Remove the active preset", options={"HIDDEN", "SKIP_SAVE"}
    )
