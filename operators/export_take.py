"""Export Take: the character with its take, for other programs."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty, StringProperty

from . import outcome

FORMATS = (
    ("NPZ", "AMASS .npz", "SMPL-X parameters as in the AMASS dataset"),
    ("FBX", "FBX", "Armature, mesh and animation"),
    ("GLTF", "glTF", "Armature, mesh and animation as .glb"),
    *((("USD", "USD", "Armature, mesh and animation"),) if bpy.app.build_options.usd else ()),
    ("BVH", "BVH", "Animation of the skeleton only"),
)


class SAMP_OT_export_take(bpy.types.Operator):
    """Export the character with its active take to a file for other programs"""

    bl_idname = "samp.export_take"
    bl_label = "Export Take"
    bl_options = {"REGISTER"}

    filepath: StringProperty(
        name="File", description="File to write", subtype="FILE_PATH", options={"SKIP_SAVE"}
    )
    kind: EnumProperty(name="Format", description="Format of the file", items=FORMATS, default="FBX")
    character: StringProperty(
        name="Character",
        description="SMPL-X armature; if empty, the active one or the only one",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.has_character(cls, context)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        from ..samp_addon.blender.takes import export
        from ..samp_addon.ui import job_from_settings

        if not self.filepath:
            name = self.character or job_from_settings.character_name(context.scene.samp)
            self.filepath = f"{export.file_stem(context, name)}{export.SUFFIXES[self.kind]}"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._export(context))

    def _export(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.takes import export
        from ..samp_addon.ui import job_from_settings

        name = self.character or job_from_settings.character_name(context.scene.samp)
        return f"Wrote '{export.export_take(context, self.filepath, self.kind, name)}'."
