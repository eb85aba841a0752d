"""Export AMASS .npz: the character's Action as an AMASS SMPL-X file."""

from __future__ import annotations

import bpy
from bpy.props import StringProperty

from . import outcome


class SAMP_OT_export_npz(bpy.types.Operator):
    """Export the character's active Action as an AMASS SMPL-X .npz file"""

    bl_idname = "samp.export_npz"
    bl_label = "Export AMASS .npz"
    bl_options = {"REGISTER"}

    filepath: StringProperty(name="File", description="File to write", subtype="FILE_PATH")
    filter_glob: StringProperty(default="*.npz", options={"HIDDEN"})
    character: StringProperty(
        name="Character", description="SMPL-X armature; if empty, the active one or the only one"
    )
    action_name: StringProperty(name="Action", description="Action to export; if empty, the active one")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.has_character(cls, context)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        from ..samp_addon.blender.takes import export

        self.filepath = self.filepath or f"{export.file_stem(context, self.character, self.action_name)}.npz"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._export(context))

    def _export(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.takes import amass_files

        path = amass_files.export_take(
            context, bpy.path.abspath(self.filepath), self.character, self.action_name
        )
        return f"Wrote '{path}'."
