"""Import AMASS .npz: a take from a file as keyframes on the character; from a script, also a take by a method."""

from __future__ import annotations

from dataclasses import replace

import bpy
from bpy.props import IntProperty, StringProperty

from . import outcome


class SAMP_OT_bake(bpy.types.Operator):
    """Import a take from an AMASS .npz file as a new Action of the character"""

    bl_idname = "samp.bake"
    bl_label = "Import AMASS .npz"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(name="File", description="AMASS .npz file of the take", subtype="FILE_PATH")
    filter_glob: StringProperty(default="*.npz", options={"HIDDEN"})
    character: StringProperty(
        name="Character", description="SMPL-X armature; if empty, the active one or the only one"
    )
    action_name: StringProperty(
        name="Action", description="Name of the new Action; if empty, that of the file"
    )
    frame_start: IntProperty(name="Start Frame", description="First frame of the new Action", default=1)
    method: StringProperty(
        name="Method",
        description="Method that bakes the sub-goals, or the action and target, of the sidebar instead of a file",
        options={"HIDDEN", "SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return outcome.has_character(cls, context)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if self.method:
            return self.execute(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        return outcome.run(self, lambda: self._generate(context) if self.method else self._bake(context))

    def _generate(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.takes import baking
        from ..samp_addon.ui import job_from_settings

        job = job_from_settings.job(context, self.method)
        job, settings = replace(job, character=self.character or job.character), context.scene.samp
        made = baking.run(context, job, start_from=settings.start_from)
        settings.seed = (settings.seed + job.variants) % 2**31  # the next one gives another take
        return baking.sentence(made)

    def _bake(self, context: bpy.types.Context) -> str:
        from ..samp_addon.blender.takes import amass_files

        path = bpy.path.abspath(self.filepath)
        armature, action = amass_files.import_take(
            context, path, self.character, self.action_name, self.frame_start
        )
        first, last = (int(frame) for frame in action.frame_range)
        return f"Baked '{action.name}' onto '{armature.name}', frames {first} to {last}."
