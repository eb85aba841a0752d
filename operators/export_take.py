"""Export Take: the character with its take in another program's file."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty, StringProperty

from . import outcome

FORMATS = (
    ("NPZ", "AMASS .npz", "SMPL-X parameters, as AMASS has them"),
    ("FBX", "FBX", "Armature, mesh and animation"),
    ("GLTF", "glTF", "Armature, mesh and animation as .glb"),
    ("USD", "USD", "Armature, mesh and animation"),
    ("BVH", "BVH", "The skeleton's animation alone"),
)


class SAMP_OT_export_take(bpy.types.Operator):
    """Write the character and its active take to a file for other programs"""

    bl_idname = "samp.export_take"
    bl_label = "Export Take"
    bl_options = {"REGISTER"}

    filepath: StringProperty(name="File", subtype="FILE_PATH", options={"SKIP_SAVE"})
    kind: EnumProperty(name="Format", items=FORMATS, default="FBX")
    character: StringProperty(
        name="Character",
        description="SMPL-X armature; empty: the active one, or the only one",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        from ..samp_addon.blender import takes

        return takes.can_bake(context, cls.poll_message_set)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        from ..samp_addon.blender import exporting

        if not self.filepath:
            self.filepath = f"take{exporting.SUFFIXES[self.kind]}"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._export(context))

    def _export(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender import asking, exporting

        name = self.character or asking.character_name(context.scene.samp)
        return f"Wrote '{exporting.export_take(context, self.filepath, self.kind, name)}'."
