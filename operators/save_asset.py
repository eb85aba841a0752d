"""Save to Asset Library: a take or a character as an asset in a new file."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import EnumProperty, StringProperty

from . import outcome
from .take_operator import TakeOperator


class SAMP_OT_save_asset(TakeOperator, bpy.types.Operator):
    """Save this take or its character, with a picture, tags and a catalogue, into a new file of an asset library"""

    bl_idname = "samp.save_asset"
    bl_label = "Save to Asset Library"
    bl_options = {"REGISTER"}  # the open file does not change

    what: EnumProperty(
        name="Save",
        description="What becomes an asset",
        items=(
            ("TAKE", "Take", "The Action of the take"),
            ("CHARACTER", "Character", "The character, in its rest pose and without Actions"),
        ),
    )
    directory: StringProperty(
        name="Library",
        description="Folder of the asset library; if empty, the first one of the preferences",
        subtype="DIR_PATH",
    )

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if bpy.app.background:
            return self.execute(context)
        self.directory = self.directory or _first_library(context)
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._save(context))

    def _save(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.assets import saving
        from ..samp_addon.errors import SampError

        library = _first_library(context)
        given = self.directory or library
        if not given:
            raise SampError("There is no asset library; add one in the preferences, or choose a folder.")
        folder = Path(bpy.path.abspath(given))
        if given == library:
            saving.make_library(folder)
        owner = self.owner(context)
        if self.what == "CHARACTER":
            path = saving.save_character(owner, folder)
            return f"Saved '{owner.name}' to '{path}'."
        take = self.take(context)
        return f"Saved '{take.name}' to '{saving.save_take(context, owner, take, folder)}'."


def _first_library(context: bpy.types.Context) -> str:
    """Return the folder of the first asset library of the preferences, or an empty string."""
    return next((library.path for library in context.preferences.filepaths.asset_libraries), "")
