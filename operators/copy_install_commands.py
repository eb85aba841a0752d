"""Copy Install Commands: the commands that install missing Python packages."""

from __future__ import annotations

import bpy

from . import outcome


class SAMP_OT_copy_install_commands(bpy.types.Operator):
    """Copy the commands that install the missing Python packages to the clipboard"""

    bl_idname = "samp.copy_install_commands"
    bl_label = "Copy Install Commands"
    bl_options = {"INTERNAL"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._copy(context))

    def _copy(self, context: bpy.types.Context) -> str:
        from ..samp_addon.ui import preferences

        context.window_manager.clipboard = preferences.install_commands()
        return "Copied the commands; paste them into a terminal, then restart Blender."
